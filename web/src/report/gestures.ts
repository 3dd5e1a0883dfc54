import type { View } from '../viewer/view.ts';
import type { Cameras } from './cameras.ts';

const TURN_PIXELS = 24;
const ZOOM = 1.15;

interface Place {
  x: number;
  y: number;
}

/**
 * One finger or the left button turns; two fingers zoom and move, as do the wheel and the other buttons. The wheel scrolls the page
 * until the view has the focus, and so do fingers that move up or down.
 */
export function listen(view: View, cameras: Cameras): void {
  const { element } = view;
  const held = new Map<number, Place>();
  let panning = false;

  function place(event: MouseEvent): Place {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  function moved(event: PointerEvent): void {
    const before = held.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    const other = [...held].find(([id]) => id !== event.pointerId)?.[1];
    held.set(event.pointerId, now);
    const [x, y] = [now.x - before.x, now.y - before.y];
    if (other) {
      const [from, to] = [distance(before, other), distance(now, other)];
      const middle = { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 };
      if (from > 1 && to > 1) cameras.zoom(view, from / to, middle.x, middle.y);
      cameras.pan(view, x / 2, y / 2);
    } else if (panning) cameras.pan(view, x, y);
    else cameras.turn(x, y);
  }

  element.addEventListener('pointerdown', (event) => {
    if (held.size === 2) return;
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    held.set(event.pointerId, place(event));
    panning = event.button !== 0 || event.shiftKey;
  });
  element.addEventListener('pointermove', moved);
  for (const end of ['pointerup', 'pointercancel'] as const)
    element.addEventListener(end, (event) => held.delete(event.pointerId));
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  element.addEventListener(
    'wheel',
    (event) => {
      if (document.activeElement !== element && !event.ctrlKey) return;
      event.preventDefault();
      const { x, y } = place(event);
      // Browsers count in pixels or in lines.
      const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? event.deltaY * 24 : event.deltaY;
      cameras.zoom(view, Math.exp(Math.min(Math.max(pixels, -240), 240) * 0.0016), x, y);
    },
    { passive: false },
  );
  element.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !pressed(view, cameras, event)) return;
    event.preventDefault();
  });
}

/** Does what a key stands for; tells whether it stands for anything. */
function pressed(view: View, cameras: Cameras, event: KeyboardEvent): boolean {
  const arrows: Record<string, [number, number]> = {
    ArrowLeft: [-TURN_PIXELS, 0],
    ArrowRight: [TURN_PIXELS, 0],
    ArrowUp: [0, -TURN_PIXELS],
    ArrowDown: [0, TURN_PIXELS],
  };
  const arrow = arrows[event.key];
  if (arrow && event.shiftKey) cameras.pan(view, ...arrow);
  else if (arrow) cameras.turn(...arrow);
  else if (event.key === '+' || event.key === '=') cameras.zoom(view, 1 / ZOOM);
  else if (event.key === '-') cameras.zoom(view, ZOOM);
  else if (event.key === '0' || event.key === 'Home') cameras.whole();
  else return false;
  return true;
}

function distance(a: Place, b: Place): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
