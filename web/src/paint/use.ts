import type { Studio } from '../app/studio.ts';
import type { Mask } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { h, uniqueId } from '../ui/dom.ts';
import { notify } from '../ui/notices.ts';
import type { Painter } from './painter.ts';
import { maskSetting, rigidSetting, type Setting } from './setting.ts';

/** What can be done with a mask that is saved: put it into the pipeline. */
export function useOf(studio: Studio, painter: Painter, mask: Mask): HTMLElement[] {
  if (mask.side !== 'target') {
    return [h('p', { class: 'hint' }, 'Pipelines take masks of the target. This one is for your own programs.')];
  }
  return mask.kind === 'weights' ? useWeights(studio, painter, mask) : useComponents(studio, painter);
}

function useWeights(studio: Studio, painter: Painter, mask: Mask): HTMLElement[] {
  const id = uniqueId('pattern');
  const pattern = h('input', { id, type: 'text', value: '*', spellcheck: 'false' });
  return [
    h('div', { class: 'field-row' }, h('label', { for: id }, 'For the shapes'), pattern),
    h('p', { class: 'hint' }, 'A name, or a pattern such as jaw*; * is all of them.'),
    h(
      'div',
      { class: 'row' },
      button({
        label: 'Use in the pipeline',
        disabled: () => !painter.takesMasks.value,
        run: () =>
          void put(studio, maskSetting(studio.pipeline.pipeline.peek()?.value, pattern.value.trim() || '*', mask.file)),
      }),
    ),
  ];
}

function useComponents(studio: Studio, painter: Painter): HTMLElement[] {
  return [
    h(
      'div',
      { class: 'row' },
      button({
        label: 'Use in the pipeline',
        run: () =>
          void put(studio, rigidSetting(studio.pipeline.pipeline.peek()?.value, [...painter.components.value])),
      }),
    ),
  ];
}

async function put(studio: Studio, { path, value, says }: Setting): Promise<void> {
  if (await studio.pipeline.set(path, value)) notify(says, 'Ctrl Z takes it back; Stages shows it.', 'info', 'paint');
}
