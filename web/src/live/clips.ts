import type { Studio } from '../app/studio.ts';
import type { Clip, Step } from '../protocol/types.ts';
import { select } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import { chosenClip, clipSetting } from './clip.ts';

const SEVERAL = '*';
const SHAPES = '';

/** The clips of the source's file, where it holds several; another one becomes `source.poses` of the pipeline. */
export function clipChoice(studio: Studio): HTMLElement {
  const clips = () => studio.session.value?.poses?.clips ?? [];
  const shapes = () => studio.session.value?.poses?.are === 'shapes';
  const present = () => chosenClip(studio.session.value?.poses ?? null);
  const choice = select<string>({
    label: 'Clip',
    options: () => [
      ...(shapes() ? [{ value: SHAPES, label: 'Shapes' }] : []),
      ...(present() === SEVERAL ? [{ value: SEVERAL, label: 'Several clips' }] : []),
      ...clips().map((clip) => ({ value: clip.name, label: describe(clip) })),
    ],
    value: () => present() ?? SHAPES,
    change: (name) => {
      const { path, value } = clipSetting(studio.pipeline.pipeline.peek()?.value, name);
      void studio.pipeline.set(path as Step[], value);
    },
  });
  const element = h('span', { class: 'clip-choice', title: 'The clip whose motion is carried over' }, choice);
  effect(() => {
    element.hidden = clips().length < (shapes() ? 1 : 2);
  });
  return element;
}

function describe({ name, seconds, frames }: Clip): string {
  return `${name} · ${seconds.toFixed(2)} s, ${frames} frames`;
}
