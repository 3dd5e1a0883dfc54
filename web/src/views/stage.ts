import { display } from '../app/display.ts';
import type { Meshes } from '../app/meshes.ts';
import type { Studio } from '../app/studio.ts';
import { MarkerTool } from '../markers/tool.ts';
import type { FrameScalar, Point, Session, Side } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import { effect, signal } from '../ui/signal.ts';
import { theme } from '../ui/theme.ts';
import type { ColourMapName } from '../viewer/colours.ts';
import type { MeshData } from '../viewer/surface.ts';
import { Viewer } from '../viewer/viewer.ts';
import { StageCamera } from './camera.ts';
import { labelsOf, type Place, sameLabels } from './labels.ts';
import { paletteOf } from './palette.ts';
import { Pane, type Role } from './pane.ts';
import { listenToPointer, type PaneTool } from './pointer.ts';

/** How long a place is pointed at, and how it goes. */
const PLACE_MILLISECONDS = 6000;
const FADE = [0.8, 0.6, 0.4, 0.2];
const FADE_MILLISECONDS = 150;

const XRAY_OPACITY = 0.35;
const GHOST_OPACITY = 0.4;
const NONE: ReadonlySet<number> = new Set();

/** The panes with both meshes, kept in step with what the studio knows. */
export class Stage {
  readonly element = h('div', { class: 'stage' });
  readonly viewer: Viewer;
  readonly camera: StageCamera;
  readonly markerTool: MarkerTool;
  readonly panes = signal<Pane[]>([]);
  /** What the hand does; painting replaces the setting of points. */
  readonly tool = signal<PaneTool>(null as unknown as PaneTool);
  /** Colours that a tool shows in place of those of the result. */
  readonly painted = signal<{ side: string; values: Float32Array } | null>(null);
  /** Components that a tool has chosen or hovers over. */
  readonly tinted = signal<{ side: string; components: ReadonlySet<number> } | null>(null);
  private readonly place = signal<Place | null>(null);
  private placeTimer = 0;
  private readonly studio: Studio;
  /** Count changes that later steps depend on: effects of one signal run in no fixed order. */
  private readonly surfaces = signal(0);
  private readonly moved = signal(0);
  private readonly ghosts = signal(0);
  private readonly made = new Map<Role, Pane>();
  /** Which opening of files is shown. */
  private opened: number | null = null;

  constructor(studio: Studio) {
    this.studio = studio;
    this.viewer = new Viewer(this.element);
    this.camera = new StageCamera(this.viewer, () => this.panes.peek());
    this.markerTool = new MarkerTool(studio);
    this.tool.value = this.markerTool;
    effect(() => this.arrange(display.threeViews.value ? ['source', 'rest', 'result'] : ['source', 'result']));
    effect(() => {
      const lead = this.activePane();
      if (display.linked.value && lead) this.camera.link(lead);
    });
    effect(() => this.showMeshes(this.panes.value, studio.meshes.value, studio.session.peek()));
    effect(() => this.showPositions());
    effect(() => this.showValues());
    effect(() => this.showLook());
    effect(() => this.showHidden());
    effect(() => this.showTint());
    effect(() => this.showLabels());
  }

  pane(role: Role): Pane | null {
    return this.panes.peek().find((pane) => pane.role === role) ?? null;
  }

  /** The pane of the keyboard, else that below the pointer, else the source. */
  activePane(): Pane | null {
    const panes = this.panes.peek();
    return (
      panes.find((pane) => pane.surfaceElement === document.activeElement) ??
      panes.find((pane) => pane.pointer !== null) ??
      panes[0] ??
      null
    );
  }

  /** Flies to a pair, or to any points of both meshes. */
  flyToPoints(source: Point | null, target: Point | null, holds?: () => boolean): void {
    const places = new Map();
    for (const pane of this.panes.peek()) {
      const point = pane.side === 'source' ? source : target;
      const place = point && pane.locate(point);
      if (place) places.set(pane, place);
    }
    const selected = this.studio.selected.peek();
    this.camera.flyTo(places, holds ?? (() => selected !== null && this.studio.selected.peek() === selected));
  }

  /** Flies to a place and points at it for a while; the other mesh flies to the matching place if that is known. */
  showPlace(side: Side, point: Point, other: Point | null = null): void {
    const isShown = () => this.place.peek()?.point === point;
    const [source, target] = side === 'source' ? [point, other] : [other, point];
    this.flyToPoints(source, target, isShown);
    window.clearTimeout(this.placeTimer);
    this.place.value = { side, point, strength: 1 };
    const fade = (step: number) => {
      this.place.value = step < FADE.length ? { side, point, strength: FADE[step] } : null;
      if (this.place.peek()) this.placeTimer = window.setTimeout(() => fade(step + 1), FADE_MILLISECONDS);
    };
    this.placeTimer = window.setTimeout(() => fade(0), PLACE_MILLISECONDS);
  }

  private arrange(roles: Role[]): void {
    const shown = roles.map((role) => this.made.get(role) ?? this.makePane(role));
    for (const pane of this.panes.peek()) if (!shown.includes(pane)) pane.detach();
    for (const pane of shown) pane.attach(this.element);
    this.element.dataset.panes = String(shown.length);
    const before = this.panes.peek();
    this.panes.value = shown;
    if (display.linked.peek() && before.length > 0)
      for (const pane of shown) if (!before.includes(pane)) this.camera.join(pane, before);
    this.viewer.invalidate();
  }

  private makePane(role: Role): Pane {
    const pane = new Pane(this.viewer, role);
    listenToPointer(pane, () => this.tool.peek(), this.camera);
    this.made.set(role, pane);
    return pane;
  }

  private showMeshes(panes: Pane[], meshes: Meshes | null, session: Session | null): void {
    for (const pane of panes) {
      if (!meshes) pane.clear();
      else if (pane.surface?.rest !== meshes[pane.side].positions) {
        pane.show(meshes[pane.side], display.up[pane.side].value ?? session?.[pane.side]?.up ?? 'y');
      } else pane.surface.setUp(display.up[pane.side].value ?? session?.[pane.side]?.up ?? 'y');
    }
    // Another clip of the same files leaves the cameras where they are.
    if (meshes && session && session.opened !== this.opened) {
      if (this.opened !== null) this.camera.reset();
      this.opened = session.opened;
    }
    this.surfaces.value = this.surfaces.peek() + 1;
    this.viewer.invalidate();
  }

  private showPositions(): void {
    void this.surfaces.value;
    const { live, meshes } = this.studio;
    const data = meshes.peek();
    const source = display.sourceAtRest.value ? null : (live.source.value?.positions ?? null);
    const result = live.target.value?.positions ?? null;
    const truth = live.truth.value?.positions ?? null;
    const content = display.target.value;
    live.wantsTruth.value = content === 'truth' || content === 'over_truth';
    if (!data) return;
    const rest = data.target.positions;
    const main = content === 'rest' ? null : content === 'truth' ? truth : result;
    const over = content === 'over_truth' ? (truth ?? rest) : content === 'over_rest' ? rest : null;
    const shown = { source: source ?? data.source.positions, rest, result: main ?? rest };
    const changed = this.panes.peek().filter((pane) => {
      const moved = pane.surface?.setPositions(shown[pane.role]) ?? false;
      return (pane.role === 'result' && this.showGhost(pane, data.target, over)) || moved;
    });
    this.moved.value = this.moved.peek() + 1;
    this.invalidate(changed);
  }

  private showGhost(pane: Pane, data: MeshData, positions: Float32Array | null): boolean {
    const came = pane.showGhost(positions ? data : null);
    if (came) this.ghosts.value = this.ghosts.peek() + 1;
    const moved = positions !== null && (pane.ghost?.setPositions(positions) ?? false);
    return came || moved;
  }

  /** What moves is drawn only where it is seen. */
  private invalidate(panes: readonly Pane[]): void {
    this.viewer.invalidate(
      true,
      panes.map((pane) => pane.view),
    );
  }

  private showValues(): void {
    void this.surfaces.value;
    const { live } = this.studio;
    const painted = this.painted.value;
    const shown = display.target.value === 'truth' ? live.truth.value : live.target.value;
    const named = live.scalar.value;
    const changed = this.panes.peek().filter(({ surface, side, role }) => {
      if (painted) return surface?.setValues(painted.side === side ? painted.values : null, 'mask', 0, 1);
      if (role === 'result' && named && shown?.values && shown.scalar?.name === named) {
        return surface?.setValues(shown.values, mapOf(shown.scalar), shown.scalar.low, shown.scalar.high);
      }
      return surface?.setValues(null);
    });
    this.invalidate(changed);
  }

  private showLook(): void {
    const palette = paletteOf(theme.value);
    const [wireframe, xray] = [display.wireframe.value, display.xray.value];
    void [this.surfaces.value, this.ghosts.value];
    this.viewer.gap.copy(palette.gap);
    for (const pane of this.panes.peek()) {
      pane.view.background.copy(palette.background);
      pane.view.transparent = xray;
      pane.surface?.setLook(palette[pane.side], palette.line);
      pane.surface?.setWireframe(wireframe);
      pane.surface?.setOpacity(xray ? XRAY_OPACITY : 1);
      pane.ghost?.setLook(palette.ghost, palette.line);
      pane.ghost?.setOpacity(GHOST_OPACITY);
    }
    this.viewer.invalidate();
  }

  private showHidden(): void {
    const hidden = { source: this.studio.hidden.source.value, target: this.studio.hidden.target.value };
    void [this.surfaces.value, display.target.value];
    for (const pane of this.panes.peek()) {
      pane.surface?.hide(hidden[pane.side]);
      pane.ghost?.hide(hidden[pane.side]);
    }
    this.viewer.invalidate();
  }

  private showTint(): void {
    void this.surfaces.value;
    const tinted = this.tinted.value;
    for (const pane of this.panes.peek()) pane.surface?.tint(tinted?.side === pane.side ? tinted.components : NONE);
    this.viewer.invalidate();
  }

  private showLabels(): void {
    const { studio } = this;
    const state = {
      pairs: studio.markers.pairs.value,
      selected: studio.selected.value,
      hovered: studio.hovered.value,
      dragged: studio.dragged.value,
      place: this.place.value,
    };
    // Points follow the surfaces that they lie on.
    void this.moved.value;
    const changed = this.panes.peek().filter((pane) => {
      const labels = labelsOf(pane, state);
      const same = sameLabels(pane.view.labels, labels);
      pane.view.labels = labels;
      return !same;
    });
    this.invalidate(changed);
  }
}

const MAPS: Record<string, ColourMapName> = { component_gaps: 'gaps', pair_confidence: 'confidence' };

export function mapOf({ name, low }: FrameScalar): ColourMapName {
  return MAPS[name] ?? (low < 0 ? 'stretch' : 'error');
}
