import type { Studio } from '../app/studio.ts';
import { api, describeError, RequestError } from '../protocol/client.ts';
import { floats } from '../protocol/container.ts';
import type { Mask, Side } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import { notify } from '../ui/notices.ts';
import { computed, effect, flush, signal } from '../ui/signal.ts';
import type { Pane } from '../views/pane.ts';
import type { PaneTool } from '../views/pointer.ts';
import type { Stage } from '../views/stage.ts';
import { PaintedMask } from './mask.ts';

export type PaintKind = 'weights' | 'components';

/** The brush, the mask below it, and the components that are chosen by click. */
export class Painter implements PaneTool {
  readonly kind = signal<PaintKind>('weights');
  readonly side = signal<Side>('target');
  readonly radius = signal(0.06);
  readonly strength = signal(0.5);
  readonly erases = signal(false);
  readonly components = signal<ReadonlySet<string>>(new Set());
  readonly masks = signal<Mask[]>([]);
  /** Whether something was painted that is not saved. */
  readonly unsaved = signal(false);
  /** The file that holds what is painted, or held it before the last strokes. */
  readonly saved = signal<Mask | null>(null);
  /** Whether the pipeline can take a mask: its poses are shapes. */
  readonly takesMasks: { readonly value: boolean };
  private readonly studio: Studio;
  private readonly stage: Stage;
  private readonly ring = h('div', { class: 'brush-ring' });
  private mask = new PaintedMask(0);

  constructor(studio: Studio, stage: Stage) {
    this.studio = studio;
    this.stage = stage;
    this.takesMasks = computed(() => studio.session.value?.poses?.are === 'shapes');
    effect(() => {
      const on = studio.panel.value === 'paint';
      stage.tool.value = on ? this : stage.markerTool;
      if (on) void this.list();
      this.show(on);
    });
    effect(() => {
      void [this.side.value, studio.meshes.value];
      this.clear();
    });
    effect(() => this.showComponents());
  }

  hover(pane: Pane, x: number, y: number): void {
    if (this.kind.peek() === 'components') this.hoverComponent(pane, x, y);
    else this.moveRing(pane, x, y);
  }

  leave(_pane: Pane): void {
    this.ring.remove();
    if (this.kind.peek() === 'components') this.showComponents();
  }

  begins(pane: Pane, x: number, y: number): boolean {
    if (pane.side !== this.side.peek() || this.kind.peek() !== 'weights' || !pane.pick(x, y)) return false;
    this.mask.beginStroke();
    this.drag(pane, x, y);
    return true;
  }

  drag(pane: Pane, x: number, y: number): void {
    this.moveRing(pane, x, y);
    const hit = pane.pick(x, y);
    if (!hit || !pane.picker) return;
    const strength = this.strength.peek() * (this.erases.peek() ? -1 : 1);
    pane.picker.verticesNear(hit.point, this.radius.peek(), (vertex, distance) =>
      this.mask.dab(vertex, distance, strength),
    );
    this.changed();
  }

  release(): void {}

  cancel(): void {
    this.mask.undo();
    this.changed();
  }

  click(pane: Pane, x: number, y: number): void {
    const hit = pane.side === this.side.peek() && this.kind.peek() === 'components' ? pane.pick(x, y) : null;
    if (!hit || !pane.surface) return;
    const name = this.names()[pane.surface.components[hit.triangle]];
    const chosen = new Set(this.components.peek());
    if (!chosen.delete(name)) chosen.add(name);
    this.components.value = chosen;
    this.unsaved.value = true;
  }

  /** Fills, empties or inverts the whole mask. */
  change(how: (weight: number) => number): void {
    this.mask.change(how);
    this.changed();
  }

  clear(): void {
    this.mask = new PaintedMask(this.vertexCount());
    this.components.value = new Set();
    this.unsaved.value = false;
    this.saved.value = null;
    this.show(this.studio.panel.peek() === 'paint');
  }

  /** Takes back a stroke of the brush, or makes it again, and says so. */
  step(redo: boolean): void {
    const can = redo ? this.mask.canRedo : this.mask.canUndo;
    if (can) {
      if (redo) this.mask.redo();
      else this.mask.undo();
      this.changed();
    }
    const done = redo ? 'Painted the stroke again.' : 'Undid a stroke of the brush.';
    const nothing = redo ? 'There is no stroke to paint again.' : 'There is no stroke to undo.';
    notify(can ? done : nothing, null, 'info', 'undo');
  }

  /** Saves what is painted. Whether a file of that name is there that is another mask than this one, so that a person must be asked. */
  async save(name: string, replace = false): Promise<boolean> {
    const [side, kind] = [this.side.peek(), this.kind.peek()];
    const is = this.saved.peek();
    const isSame = is !== null && is.name === name && is.side === side && is.kind === kind;
    try {
      const mask =
        kind === 'weights'
          ? await api.saveMask(side, name, { weights: this.mask.weights }, replace || isSame)
          : await api.saveComponents(side, name, [...this.components.peek()], replace || isSame);
      this.unsaved.value = false;
      this.saved.value = mask;
      notify(`Saved ${mask.file}.`);
      await this.list();
      return false;
    } catch (error) {
      if (error instanceof RequestError && error.status === 409 && !replace) return true;
      const { message, hint } = describeError(error);
      notify(message, hint, 'error', 'paint');
      return false;
    }
  }

  async load(mask: Mask): Promise<void> {
    await this.report(async () => {
      const weights = floats((await api.mask(mask.side, mask.name)).arrays, 'weights');
      this.side.value = mask.side;
      this.kind.value = mask.kind;
      // A change of side clears what was painted; that must be over before the mask is shown.
      flush();
      this.mask = new PaintedMask(weights.length, weights);
      if (mask.kind === 'components') this.components.value = this.componentsIn(weights);
      this.saved.value = mask;
      this.unsaved.value = false;
      this.show(true);
    });
  }

  async remove(mask: Mask): Promise<void> {
    await this.report(async () => {
      this.masks.value = (await api.deleteMask(mask.side, mask.name)).masks;
    });
  }

  private async list(): Promise<void> {
    await this.report(async () => {
      this.masks.value = (await api.masks()).masks;
    });
  }

  private async report(work: () => Promise<void>): Promise<void> {
    try {
      await work();
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error');
    }
  }

  private componentsIn(weights: Float32Array): Set<string> {
    const mesh = this.studio.meshes.peek()?.[this.side.peek()];
    const names = this.names();
    const found = new Set<string>();
    mesh?.components.forEach((component, t) => {
      if (weights[mesh.triangles[t * 3]] > 0.5) found.add(names[component]);
    });
    return found;
  }

  private names(): string[] {
    return (this.studio.session.peek()?.[this.side.peek()]?.components ?? []).map((component) => component.name);
  }

  private vertexCount(): number {
    return (this.studio.meshes.peek()?.[this.side.peek()].positions.length ?? 0) / 3;
  }

  private changed(): void {
    this.unsaved.value = true;
    this.show(true);
  }

  private show(on: boolean): void {
    const weights = on && this.kind.value === 'weights';
    this.stage.painted.value = weights ? { side: this.side.peek(), values: this.mask.weights } : null;
    if (!on) {
      this.ring.remove();
      this.stage.tinted.value = null;
    }
  }

  private showComponents(hovered: number | null = null): void {
    if (this.studio.panel.value !== 'paint' || this.kind.value !== 'components') {
      this.stage.tinted.value = null;
      return;
    }
    const names = this.names();
    const chosen = new Set([...this.components.value].map((name) => names.indexOf(name)));
    if (hovered !== null) chosen.add(hovered);
    this.stage.tinted.value = { side: this.side.value, components: chosen };
  }

  private hoverComponent(pane: Pane, x: number, y: number): void {
    const hit = pane.side === this.side.peek() ? pane.pick(x, y) : null;
    this.showComponents(hit && pane.surface ? pane.surface.components[hit.triangle] : null);
  }

  private moveRing(pane: Pane, x: number, y: number): void {
    const hit = pane.side === this.side.peek() ? pane.pick(x, y) : null;
    if (!hit) {
      this.ring.remove();
      return;
    }
    const pixels = pane.view.pixelsAt(hit.point) * this.radius.peek();
    if (this.ring.parentElement !== pane.element) pane.element.append(this.ring);
    Object.assign(this.ring.style, {
      width: `${2 * pixels}px`,
      height: `${2 * pixels}px`,
      transform: `translate(${x - pixels}px, ${y - pixels}px)`,
    });
  }
}
