/** The 3D view of a report: fills the section that the page has for it. */
import { h } from '../ui/dom.ts';
import { controls } from './controls.ts';
import type { ReportData } from './data.ts';
import style from './report.css?inline';
import { Stage } from './stage.ts';

const HELP =
  'Drag to turn both meshes. Two fingers or the right button move them, and a click on a view lets the wheel zoom. ' +
  'Keys: arrows, plus, minus, 0.';

function start(section: HTMLElement, data: ReportData): void {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(style);
  document.adoptedStyleSheets.push(sheet);
  // It is there for those without scripts.
  document.getElementById('view-3d-without')?.remove();
  let stage: Stage;
  try {
    stage = new Stage(data);
  } catch {
    const sentence = 'This browser has no WebGL 2, which the view needs. The pictures below show the same poses.';
    section.append(h('p', { class: 'note' }, sentence));
    return;
  }
  const parts = controls(
    data.poses,
    (shown) => stage.show(shown),
    () => stage.cameras.whole(),
  );
  const below = h('div', { class: 'v3-below' }, parts.options, parts.legend);
  section.append(parts.list, stage.element, below, parts.reasons, h('p', { class: 'note' }, HELP));
  parts.update();
  // For tests.
  Object.assign(window, { mimesh: { stage } });
}

const section = document.getElementById('view-3d');
const data = document.getElementById('view-3d-data')?.textContent;
if (section && data) start(section, JSON.parse(data));
