import { labelAt } from '../viewer/labels.ts';
import type { Pane } from './pane.ts';

/** What the hand does in a pane, told to the tools of the stage. Places are pixels of the pane. */
export interface PaneTool {
  hover(pane: Pane, x: number, y: number, label: number | null): void;
  leave(pane: Pane): void;
  click(pane: Pane, x: number, y: number, label: number | null, snap: boolean): void;
  /** Whether a stroke that begins here belongs to the tool; else it turns the camera. */
  begins(pane: Pane, x: number, y: number, label: number | null): boolean;
  drag(pane: Pane, x: number, y: number, snap: boolean): void;
  release(pane: Pane): void;
  cancel(pane: Pane): void;
}

export interface PaneCamera {
  turn(pane: Pane, x: number, y: number): void;
  pan(pane: Pane, x: number, y: number): void;
  zoom(pane: Pane, factor: number, x: number, y: number): void;
}

/** A hand that trembles this many pixels still clicks. */
const CLICK_PIXELS = 4;

type Stroke = { kind: 'click' | 'turn' | 'pan' | 'tool'; x: number; y: number; label: number | null; pointer: number };

/** Turns pointer events of a pane into strokes: click, turn, pan, or those of the tool. */
export function listenToPointer(pane: Pane, tool: () => PaneTool, camera: PaneCamera): void {
  const element = pane.surfaceElement;
  let stroke: Stroke | null = null;
  let last = { x: 0, y: 0 };

  function place(event: MouseEvent): { x: number; y: number } {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  function down(event: PointerEvent): void {
    if (stroke) return;
    const { x, y } = place(event);
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    last = { x, y };
    const label = labelAt(pane.view, x, y)?.id ?? null;
    const panning = event.button !== 0;
    const tools = !panning && !event.altKey && tool().begins(pane, x, y, label);
    stroke = { kind: panning ? 'pan' : tools ? 'tool' : 'click', x, y, label, pointer: event.pointerId };
    pane.view.stopFlight();
  }

  function move(event: PointerEvent): void {
    const { x, y } = place(event);
    pane.pointer = { x, y };
    if (!stroke) {
      tool().hover(pane, x, y, labelAt(pane.view, x, y)?.id ?? null);
      return;
    }
    if (stroke.pointer !== event.pointerId) return;
    if (stroke.kind === 'click' && Math.hypot(x - stroke.x, y - stroke.y) > CLICK_PIXELS) stroke.kind = 'turn';
    if (stroke.kind === 'turn') camera.turn(pane, x - last.x, y - last.y);
    else if (stroke.kind === 'pan') camera.pan(pane, x - last.x, y - last.y);
    else if (stroke.kind === 'tool') tool().drag(pane, x, y, event.shiftKey);
    last = { x, y };
  }

  function up(event: PointerEvent): void {
    if (!stroke || stroke.pointer !== event.pointerId) return;
    const { kind, x, y, label } = stroke;
    stroke = null;
    if (kind === 'click') tool().click(pane, x, y, label, event.shiftKey);
    else if (kind === 'tool') tool().release(pane);
  }

  function cancel(): void {
    if (stroke?.kind === 'tool') tool().cancel(pane);
    stroke = null;
  }

  function wheel(event: WheelEvent): void {
    event.preventDefault();
    const { x, y } = place(event);
    // Browsers count in pixels or in lines.
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? event.deltaY * 24 : event.deltaY;
    camera.zoom(pane, Math.exp(Math.min(Math.max(pixels, -240), 240) * 0.0016), x, y);
  }

  element.addEventListener('pointerdown', down);
  element.addEventListener('pointermove', move);
  element.addEventListener('pointerup', up);
  element.addEventListener('pointercancel', cancel);
  element.addEventListener('keydown', (event) => event.key === 'Escape' && cancel());
  element.addEventListener('wheel', wheel, { passive: false });
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  element.addEventListener('pointerleave', () => {
    pane.pointer = null;
    tool().leave(pane);
  });
}
