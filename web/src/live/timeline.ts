import type { Studio } from '../app/studio.ts';
import type { Poses } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import { nearestFrame } from './ahead.ts';
import { clipChoice } from './clips.ts';
import { frameAt } from './frames.ts';

const USUAL_RATE = 24;
/** Longer names of poses are cut; the tooltip has them in full. */
const MOST_LETTERS = 40;

/** Plays the frames of a clip at its rate, on time: frames that come too late are left out. */
export class Player {
  private readonly studio: Studio;
  private start = 0;
  private request = 0;

  constructor(studio: Studio) {
    this.studio = studio;
    effect(() => {
      // A change of the session while it plays must not begin a second round beside the first.
      cancelAnimationFrame(this.request);
      if (studio.live.playing.value) this.begin();
    });
  }

  get poses(): Poses | null {
    const poses = this.studio.session.value?.poses ?? null;
    return poses?.are === 'frames' && poses.list.length > 0 ? poses : null;
  }

  /** The frame that is shown; null at rest. */
  get frame(): number | null {
    const pose = this.studio.live.pose.value;
    return pose && 'index' in pose ? pose.index : null;
  }

  toggle(): void {
    if (this.poses) this.studio.live.playing.value = !this.studio.live.playing.peek();
  }

  go(frame: number | null): void {
    const count = this.poses?.list.length ?? 0;
    this.studio.live.playing.value = false;
    this.studio.live.pose.value = frame === null || count === 0 ? null : { index: ((frame % count) + count) % count };
  }

  step(by: number): void {
    if (this.frame === null) this.go(by > 0 ? 0 : -1);
    else this.go(this.frame + by);
  }

  private begin(): void {
    const { live } = this.studio;
    const poses = this.poses;
    if (!poses) return;
    const rate = poses.fps ?? USUAL_RATE;
    const pose = live.pose.peek();
    const first = pose && 'index' in pose ? pose.index : 0;
    this.start = performance.now() - (first / rate) * 1000;
    const tick = (now: number) => {
      this.request = requestAnimationFrame(tick);
      const wanted = frameAt((now - this.start) / 1000, rate, poses.list.length);
      const index = nearestFrame(wanted, live.playable.value ?? 1);
      const present = live.pose.peek();
      const same = present !== null && 'index' in present && present.index === index;
      if (!same && live.caughtUp) live.pose.value = { index };
    };
    this.request = requestAnimationFrame(tick);
  }
}

/** The bar below the views: rest, play, a slider over the frames, and the name of the pose. */
export function timeline(studio: Studio, player: Player): HTMLElement {
  const slider = h('input', {
    type: 'range',
    min: 0,
    step: 1,
    'aria-label': 'Frame',
    oninput: () => player.go(Number(slider.value)),
  });
  const name = h('output', { class: 'pose-name' });
  const element = h(
    'footer',
    { class: 'timeline', 'aria-label': 'Motion' },
    h(
      'div',
      { class: 'timeline-main' },
      button({
        label: 'Rest',
        keys: '0',
        run: () => player.go(null),
        pressed: () => studio.live.pose.value === null,
      }),
      button({ label: 'Previous frame', keys: ',', icon: 'previous', bare: true, run: () => player.step(-1) }),
      playButton(studio, player),
      button({ label: 'Next frame', keys: '.', icon: 'next', bare: true, run: () => player.step(1) }),
      slider,
    ),
    h('div', { class: 'timeline-more' }, prepared(studio), name, clipChoice(studio)),
  );
  // The longest name has room, so that nothing moves from frame to frame.
  effect(() => {
    const poses = player.poses;
    const frames = poses === null ? [null] : [null, ...poses.list.keys()];
    const texts = frames.map((frame) => describe(studio, poses, frame).length);
    name.style.setProperty('--longest', String(Math.min(Math.max(0, ...texts), MOST_LETTERS)));
  });
  effect(() => {
    const poses = player.poses;
    const frame = player.frame;
    for (const control of element.querySelectorAll<HTMLInputElement | HTMLButtonElement>('button, input')) {
      control.disabled = poses === null;
    }
    slider.max = String(Math.max((poses?.list.length ?? 1) - 1, 0));
    slider.value = String(frame ?? 0);
    name.textContent = describe(studio, poses, frame);
    name.title = name.textContent;
    slider.setAttribute('aria-valuetext', name.textContent);
  });
  return element;
}

/** How far the results are that Play will show. */
function prepared(studio: Studio): HTMLElement {
  const element = h('span', { class: 'prepared', role: 'status' });
  effect(() => {
    const ahead = studio.live.ahead.value;
    const waits = studio.session.value?.poses?.are === 'frames' && studio.live.playable.value === null;
    element.textContent = !waits
      ? ''
      : ahead?.error || !ahead
        ? ''
        : `preparing ${ahead.done} of ${ahead.count} frames`;
    element.title = waits ? `Play shows the rough preview until then: ${studio.live.preparation()}` : '';
  });
  return element;
}

function playButton(studio: Studio, player: Player): HTMLElement {
  const play = button({ label: 'Play', keys: 'Space', icon: 'play', bare: true, run: () => player.toggle() });
  const pause = button({ label: 'Pause', keys: 'Space', icon: 'pause', bare: true, run: () => player.toggle() });
  effect(() => {
    play.hidden = studio.live.playing.value;
    pause.hidden = !play.hidden;
  });
  return h('span', { class: 'play' }, play, pause);
}

function describe(studio: Studio, poses: Poses | null, frame: number | null): string {
  const all = studio.session.value?.poses;
  if (!all || all.list.length === 0) return 'No poses';
  if (all.are === 'shapes') return `${all.list.length} shapes: sliders under Result`;
  if (frame === null) return `At rest · ${all.list.length} frames`;
  const pose = poses?.list[frame];
  const seconds = pose?.seconds === null || pose?.seconds === undefined ? '' : ` · ${pose.seconds.toFixed(2)} s`;
  // Names of poses count from 0 or from 1, as their files do, so no other count stands beside them.
  const name = pose?.name ?? String(frame);
  return `${/^\d+$/.test(name) ? `Pose ${name}` : name} · ${all.list.length} frames${seconds}`;
}
