import { Color } from 'three';
import { h } from '../ui/dom.ts';
import { type Frame, frameOf } from '../viewer/frame.ts';
import { Surface } from '../viewer/surface.ts';
import { View } from '../viewer/view.ts';
import { Viewer } from '../viewer/viewer.ts';
import { Cameras } from './cameras.ts';
import {
  continuesOf,
  type MeshEntry,
  type PoseEntry,
  positionsOf,
  type ReportData,
  trianglesOf,
  valuesOf,
} from './data.ts';
import { listen } from './gestures.ts';
import { componentsOf, edgesOf } from './topology.ts';

const TITLES = ['Source', 'Result'];
const HELP = 'Arrow keys turn both meshes, with Shift they move them, plus and minus zoom, 0 shows the whole.';

// Those of the still pictures.
const COLOURS = [new Color('#98b3d6'), new Color('#e2bc8c')];
const LOOKS = {
  light: { background: new Color('#f4f6f8'), line: new Color('#1b1f24'), gap: new Color('#ffffff') },
  dark: { background: new Color('#1d2329'), line: new Color('#000000'), gap: new Color('#14181c') },
};

/** What is shown of a pose. */
export interface Shown {
  pose: PoseEntry;
  rest: boolean;
  colours: boolean;
  wireframe: boolean;
}

/** Source and result side by side, seen from the same side. */
export class Stage {
  readonly element = h('div', { class: 'v3-stage' });
  readonly views: View[];
  readonly cameras: Cameras;
  private readonly viewer: Viewer;
  private readonly surfaces: Surface[];
  private isFirst = true;
  private readonly missing = h('p', { class: 'v3-missing', hidden: true }, 'The posed source is not known.');

  constructor(data: ReportData) {
    this.viewer = new Viewer(this.element);
    this.surfaces = data.meshes.map(surfaceOf);
    this.views = TITLES.map((title, side) => this.makeView(title, side));
    this.cameras = new Cameras(this.viewer, this.views, data.angles);
    for (const view of this.views) listen(view, this.cameras);
    this.viewer.canvas.setAttribute('aria-hidden', 'true');
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', () => this.setTheme(dark.matches));
    this.setTheme(dark.matches);
  }

  show({ pose, rest, colours, wireframe }: Shown): void {
    const posed = rest ? [null, null] : [pose.source, pose.result];
    const shapes = this.surfaces.map((surface, side) => {
      const coordinates = posed[side];
      return coordinates ? positionsOf(coordinates) : surface.rest;
    });
    // Both are as large as at rest beside each other, and small enough for the pose that reaches farthest.
    const frames = shapes.map((positions) => frameOf(positions, 'y'));
    const diagonal = Math.max(1, ...frames.map((frame) => frame.diagonal));
    this.surfaces.forEach((surface, side) => {
      const frame: Frame = { ...frames[side], diagonal };
      surface.placeIn(frame);
      surface.setPositions(shapes[side]);
      surface.setWireframe(wireframe);
    });
    this.cameras.fit(shapes.map((positions, side) => centred(positions, frames[side], diagonal)));
    if (this.isFirst) this.cameras.reset();
    this.isFirst = false;
    const isUnknown = !rest && pose.source === null;
    this.surfaces[0].group.visible = !isUnknown;
    this.missing.hidden = !isUnknown;
    const field = colours && !rest ? pose.field : null;
    this.surfaces[1].setValues(field && valuesOf(field), 'picture', 0, field?.high ?? 1);
    this.viewer.invalidate();
  }

  private makeView(title: string, side: number): View {
    const picture = h('div', {
      class: 'v3-surface',
      tabindex: 0,
      role: 'application',
      'aria-roledescription': '3D view',
      'aria-label': `${title}. ${HELP}`,
    });
    const pane = h(
      'div',
      { class: 'v3-pane' },
      picture,
      h('span', { class: 'v3-title' }, title),
      side === 0 && this.missing,
    );
    this.element.append(pane);
    const view = new View(picture);
    view.add(this.surfaces[side]);
    this.viewer.addView(view);
    return view;
  }

  private setTheme(dark: boolean): void {
    const { background, line, gap } = dark ? LOOKS.dark : LOOKS.light;
    this.viewer.gap.copy(gap);
    this.views.forEach((view, side) => {
      view.background.copy(background);
      this.surfaces[side].setLook({ colour: COLOURS[side], hover: COLOURS[side] }, line);
    });
    this.viewer.invalidate();
  }
}

function centred(positions: Float32Array, { centre }: Frame, diagonal: number): Float32Array {
  const middle = centre.toArray();
  return positions.map((c, i) => (c - middle[i % 3]) / diagonal);
}

function surfaceOf(mesh: MeshEntry): Surface {
  const positions = positionsOf(mesh.rest);
  const triangles = trianglesOf(mesh);
  const vertices = positions.length / 3;
  return new Surface({
    positions,
    triangles,
    components: componentsOf(triangles, vertices),
    welded: Uint32Array.from({ length: vertices }, (_, v) => v),
    edges: edgesOf(triangles, continuesOf(mesh)),
  });
}
