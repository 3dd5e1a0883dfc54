import type { Studio } from '../app/studio.ts';
import { api, describeError, RequestError } from '../protocol/client.ts';
import { floats } from '../protocol/container.ts';
import type { Mask, Side } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import { notify, settle } from '../ui/notices.ts';
import { computed, effect, type Signal, signal } from '../ui/signal.ts';
import type { Pane } from '../views/pane.ts';
import type { PaneTool } from '../views/pointer.ts';
import type { Stage } from '../views/stage.ts';
import type { Draft, PaintKind } from './draft.ts';

/** The brush, the mask below it, and the components that are chosen by click. */
export class Painter implements PaneTool {
  readonly kind: Signal<PaintKind>;
  readonly side: Signal<Side>;
  readonly radius = signal(0.06);
  readonly strength = signal(0.5);
  readonly erases = signal(false);
  /** The names of the components that are chosen. */
  readonly components: { readonly value: ReadonlySet<string> };
  readonly masks = signal<Mask[]>([]);
  /** Whether something was painted that is not saved. */
  readonly unsaved: { readonly value: boolean };
  /** The file that holds what is painted, or held it before the last strokes. */
  readonly saved: { readonly value: Mask | null };
  /** Whether the pipeline can take a mask: its poses are shapes. */
  readonly takesMasks: { readonly value: boolean };
  private readonly studio: Studio;
  private readonly stage: Stage;
  private readonly ring = h('div', { class: 'brush-ring' });

  constructor(studio: Studio, stage: Stage) {
    this.studio = studio;
    this.stage = stage;
    const { painting } = studio;
    this.kind = painting.kind;
    this.side = painting.side;
    const inDraft = <T>(read: (draft: Draft) => T) =>
      computed(() => {
        void painting.version.value;
        return read(painting.draft());
      });
    this.components = inDraft((draft) => draft.components);
    this.unsaved = inDraft((draft) => !draft.isSaved(this.kind.value));
    this.saved = inDraft((draft) => draft.file(this.kind.value));
    this.takesMasks = computed(() => studio.session.value?.poses?.are === 'shapes');
    effect(() => {
      const on = studio.panel.value === 'paint';
      stage.tool.value = on ? this : stage.markerTool;
      if (on) void this.list();
      else this.ring.remove();
    });
    effect(() => this.showWeights());
    effect(() => this.showComponents());
    studio.history.onStroke = () => {
      studio.panel.value = 'paint';
    };
    window.addEventListener('beforeunload', (event) => {
      if (painting.hasUnsaved) event.preventDefault();
    });
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
    this.studio.painting.begin(this.erases.peek() ? 'the stroke that erased' : 'the stroke');
    this.drag(pane, x, y);
    return true;
  }

  drag(pane: Pane, x: number, y: number): void {
    this.moveRing(pane, x, y);
    const hit = pane.pick(x, y);
    if (!hit || !pane.picker) return;
    const { painting } = this.studio;
    const { mask } = painting.draft();
    const strength = this.strength.peek() * (this.erases.peek() ? -1 : 1);
    pane.picker.verticesNear(hit.point, this.radius.peek(), (vertex, distance) => mask.dab(vertex, distance, strength));
    painting.changed();
  }

  release(): void {}

  cancel(): void {
    this.studio.painting.cancel();
  }

  click(pane: Pane, x: number, y: number): void {
    const hit = pane.side === this.side.peek() && this.kind.peek() === 'components' ? pane.pick(x, y) : null;
    if (!hit || !pane.surface) return;
    const name = this.names()[pane.surface.components[hit.triangle]];
    const { painting } = this.studio;
    painting.begin(`the choice of ${name}`);
    const chosen = new Set(this.components.value);
    if (!chosen.delete(name)) chosen.add(name);
    painting.draft().components = chosen;
    painting.changed();
  }

  /** Fills, empties or inverts the whole mask. */
  change(title: string, how: (weight: number) => number): void {
    const { painting } = this.studio;
    painting.begin(title);
    painting.draft().mask.change(how);
    painting.changed();
  }

  /** Saves what is painted. Whether a file of that name is there that is another mask than this one, so that a person must be asked. */
  async save(name: string, replace = false): Promise<boolean> {
    const [side, kind] = [this.side.peek(), this.kind.peek()];
    const { painting } = this.studio;
    const draft = painting.draftOn(side);
    const state = draft.state(kind);
    const isSame = draft.file(kind)?.name === name;
    try {
      const mask =
        state instanceof Float32Array
          ? await api.saveMask(side, name, { weights: state }, replace || isSame)
          : await api.saveComponents(side, name, [...state], replace || isSame);
      draft.markSaved(mask, state);
      painting.changed();
      settle('paint');
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

  /** Shows a saved mask; what was painted before comes back by undo. */
  async load(mask: Mask): Promise<void> {
    await this.report(async () => {
      const weights = floats((await api.mask(mask.side, mask.name)).arrays, 'weights');
      const { painting } = this.studio;
      this.side.value = mask.side;
      this.kind.value = mask.kind;
      const draft = painting.draftOn(mask.side);
      const state = mask.kind === 'components' ? this.componentsIn(weights) : weights.slice();
      painting.begin(`the opening of ${mask.name}`);
      draft.restore(state);
      draft.markSaved(mask, state);
      painting.changed();
    });
  }

  async remove(mask: Mask): Promise<void> {
    await this.report(async () => {
      this.masks.value = (await api.deleteMask(mask.side, mask.name)).masks;
      this.studio.painting.draftOn(mask.side).forget(mask);
      this.studio.painting.changed();
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
      settle('paint');
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error', 'paint');
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

  private showWeights(): void {
    const { painting, panel } = this.studio;
    void painting.version.value;
    const on = panel.value === 'paint' && this.kind.value === 'weights';
    this.stage.painted.value = on ? { side: this.side.value, values: painting.draft().mask.weights } : null;
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
