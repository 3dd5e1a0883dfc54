import './styles/page.css';
import { mount } from './app/shell.ts';
import { Studio } from './app/studio.ts';
import { h } from './ui/dom.ts';
import { notify } from './ui/notices.ts';
import { onEffectError } from './ui/signal.ts';

const root = document.getElementById('app');
if (!root) throw new Error('the page has no element #app');

try {
  onEffectError((error) => {
    console.error(error);
    const reason = error instanceof Error ? error.message : String(error);
    const hint = `What is saved is safe. Reload the page. The reason: ${reason}`;
    notify('A part of the page could not be updated.', hint, 'error', 'page');
  });
  const studio = new Studio();
  const stage = mount(root, studio);
  studio.start();
  // For tests by mouse: they must know where a point of a mesh is on the screen.
  Object.assign(window, { mimesh: { studio, stage } });
} catch (error) {
  // Nothing can be shown without WebGL, so the reason is all there is to show.
  const reason = error instanceof Error ? error.message : String(error);
  root.replaceChildren(
    h(
      'main',
      { class: 'cover' },
      h('div', { class: 'message failed', role: 'alert' }, h('h1', {}, 'The studio cannot start'), h('p', {}, reason)),
    ),
  );
}
