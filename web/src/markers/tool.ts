import type { Studio } from '../app/studio.ts';
import type { Hit } from '../picking/picker.ts';
import type { Point } from '../protocol/types.ts';
import { notify } from '../ui/notices.ts';
import type { Pane } from '../views/pane.ts';
import type { PaneTool } from '../views/pointer.ts';

const DRAG_PIXELS = 3;

/** Sets, moves and selects points by hand and by keys. */
export class MarkerTool implements PaneTool {
  private readonly studio: Studio;
  private grabbed: { pair: number; x: number; y: number; moved: boolean } | null = null;

  constructor(studio: Studio) {
    this.studio = studio;
  }

  hover(pane: Pane, _x: number, _y: number, label: number | null): void {
    this.studio.hovered.value = label;
    pane.surfaceElement.classList.toggle('over-label', label !== null);
  }

  leave(pane: Pane): void {
    this.studio.hovered.value = null;
    pane.surfaceElement.classList.remove('over-label');
  }

  begins(_pane: Pane, x: number, y: number, label: number | null): boolean {
    if (label === null) return false;
    this.grabbed = { pair: label, x, y, moved: false };
    this.studio.selected.value = label;
    return true;
  }

  drag(pane: Pane, x: number, y: number, snap: boolean): void {
    const { grabbed } = this;
    if (!grabbed) return;
    if (!grabbed.moved && Math.hypot(x - grabbed.x, y - grabbed.y) <= DRAG_PIXELS) return;
    grabbed.moved = true;
    const hit = pane.pick(x, y);
    // Beside the mesh the point waits where it last was.
    if (!hit) return;
    const point = pointOf(hit, snap);
    this.studio.dragged.value = { pair: grabbed.pair, side: pane.side, point };
    // A pair that the server does not know yet cannot be previewed.
    if (grabbed.pair > 0) this.studio.live.dragTo(grabbed.pair, pane.side, point);
  }

  release(_pane: Pane): void {
    const dragged = this.studio.dragged.peek();
    const { live, markers, fresh } = this.studio;
    // A click on a point chooses its pair, which the next click moves.
    if (this.grabbed && !this.grabbed.moved) fresh.value = null;
    this.grabbed = null;
    if (!dragged) return;
    // The edit before the end of the drag, or the point would flash back for one picture.
    markers.edit({ op: 'move', ...dragged });
    this.studio.dragged.value = null;
    void live.endDrag(dragged.pair, dragged.side, markers.settled());
  }

  cancel(pane: Pane): void {
    const { grabbed } = this;
    this.grabbed = null;
    this.studio.dragged.value = null;
    if (grabbed?.moved) this.studio.live.dragTo(grabbed.pair, pane.side, null);
  }

  click(pane: Pane, x: number, y: number, _label: number | null, snap: boolean): void {
    const hit = pane.pick(x, y);
    if (hit) this.set(pane, pointOf(hit, snap));
  }

  /** Whether clicks set points. Elsewhere a person looks at the meshes, and a click there would move a point unseen. */
  get setsPoints(): boolean {
    return this.studio.panel.value === 'points';
  }

  /** Sets the point of the selected pair, or begins a pair. One that was just made stays selected, and no click moves it. */
  set(pane: Pane, point: Point): void {
    const { markers, selected, fresh } = this.studio;
    if (!this.setsPoints) {
      notify('Clicks set points under Pairs.', 'A numbered point is dragged from everywhere.', 'info', 'points');
      return;
    }
    const pair = markers.pair(selected.peek());
    if (!pair || (fresh.peek()?.pair === pair.id && fresh.peek()?.complete)) {
      const [id] = markers.edit({ op: 'add', [pane.side]: point });
      selected.value = id;
      fresh.value = { pair: id, complete: false };
      return;
    }
    const wasMissing = pair[pane.side] === null;
    markers.edit({ op: 'move', pair: pair.id, side: pane.side, point });
    if (wasMissing && fresh.peek()?.pair === pair.id) fresh.value = { pair: pair.id, complete: true };
  }

  /** Moves the selected point by some pixels along the surface. */
  nudge(pane: Pane, x: number, y: number, snap: boolean): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    const point = pair?.[pane.side];
    const place = point && pane.locate(point);
    const pixel = place && pane.view.project(place.position);
    if (!pair || !pixel) return;
    const hit = pane.pick(pixel[0] + x, pixel[1] + y);
    if (hit) this.studio.markers.edit({ op: 'move', pair: pair.id, side: pane.side, point: pointOf(hit, snap) });
  }

  /** Another pair is begun by the next click. */
  startNew(): void {
    this.studio.selected.value = null;
  }
}

function pointOf(hit: Hit, snap: boolean): Point {
  return snap ? { vertex: hit.vertex } : { triangle: hit.triangle, barycentric: hit.barycentric };
}
