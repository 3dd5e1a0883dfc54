import { Vector3 } from 'three';
import { pointOn, triangleNormal } from '../picking/barycentric.ts';
import { type Hit, Picker } from '../picking/picker.ts';
import type { Point, Side } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import type { Label } from '../viewer/label.ts';
import { type MeshData, Surface } from '../viewer/surface.ts';
import { View } from '../viewer/view.ts';
import type { Viewer } from '../viewer/viewer.ts';

export type Role = 'source' | 'rest' | 'result';

const TITLES: Record<Role, string> = { source: 'Source', rest: 'Target at rest', result: 'Target' };

/** One picture of the stage: a mesh that can be picked, perhaps a second one that lies over it, and a line of controls. */
export class Pane {
  readonly role: Role;
  readonly side: Side;
  readonly element: HTMLElement;
  readonly head: HTMLElement;
  readonly foot: HTMLElement;
  readonly view: View;
  surface: Surface | null = null;
  ghost: Surface | null = null;
  picker: Picker | null = null;
  /** Where the pointer was last, in pixels of the element. */
  pointer: { x: number; y: number } | null = null;
  private readonly viewer: Viewer;

  constructor(viewer: Viewer, role: Role) {
    this.viewer = viewer;
    this.role = role;
    this.side = role === 'source' ? 'source' : 'target';
    this.head = h('header', { class: 'pane-head' }, h('h2', {}, TITLES[role]));
    this.foot = h('div', { class: 'pane-foot' });
    const surface = h('div', {
      class: 'pane-surface',
      tabindex: 0,
      role: 'application',
      'aria-roledescription': '3D view',
      'aria-label': `${TITLES[role]}. Arrow keys turn the view, plus and minus zoom, Enter sets a point at the centre.`,
    });
    this.element = h(
      'section',
      { class: `pane pane-${role}`, 'aria-label': TITLES[role] },
      surface,
      this.head,
      this.foot,
    );
    this.view = new View(surface);
    this.view.occluded = (label) => this.isBehind(label);
  }

  get surfaceElement(): HTMLElement {
    return this.view.element;
  }

  show(data: MeshData, up: 'x' | 'y' | 'z'): void {
    this.clear();
    this.surface = new Surface(data, up);
    this.picker = new Picker(this.surface);
    this.view.add(this.surface);
    this.viewer.invalidate();
  }

  /** A second mesh of the same make, over the first; tells whether it has come or gone. */
  showGhost(data: MeshData | null): boolean {
    if (!data === !this.ghost || !this.surface) return false;
    if (this.ghost) {
      this.view.remove(this.ghost);
      this.ghost.dispose();
      this.ghost = null;
    } else if (data) {
      this.ghost = new Surface(data, this.surface.frame.up);
      this.ghost.placeIn(this.surface.frame);
      this.view.add(this.ghost);
    }
    return true;
  }

  clear(): void {
    this.showGhost(null);
    if (!this.surface) return;
    this.view.remove(this.surface);
    this.surface.dispose();
    this.surface = null;
    this.picker = null;
  }

  attach(stage: HTMLElement): void {
    stage.append(this.element);
    if (!this.viewer.views.includes(this.view)) this.viewer.addView(this.view);
  }

  /** Takes the pane off the stage; it may come back. */
  detach(): void {
    this.clear();
    this.viewer.removeView(this.view);
    this.element.remove();
  }

  /** What lies below a pixel of the pane. */
  pick(x: number, y: number): Hit | null {
    return this.picker?.cast(this.view.rayAt(x, y)) ?? null;
  }

  /** Where a point of the mesh is now, with the normal there, in the unit frame. */
  locate(point: Point): { position: Vector3; normal: Vector3 } | null {
    const { surface } = this;
    if (!surface) return null;
    if ('vertex' in point) return this.locateVertex(surface, point.vertex);
    if (point.triangle * 3 + 2 >= surface.triangles.length) return null;
    return {
      position: pointOn(surface.positions, surface.triangles, point.triangle, point.barycentric).applyMatrix4(
        surface.matrix,
      ),
      normal: triangleNormal(surface.positions, surface.triangles, point.triangle).transformDirection(surface.matrix),
    };
  }

  private locateVertex(surface: Surface, vertex: number): { position: Vector3; normal: Vector3 } | null {
    if (vertex * 3 + 2 >= surface.positions.length) return null;
    const normals = surface.geometry.attributes.normal.array as Float32Array;
    return {
      position: new Vector3().fromArray(surface.positions, vertex * 3).applyMatrix4(surface.matrix),
      normal: new Vector3().fromArray(normals, vertex * 3).transformDirection(surface.matrix),
    };
  }

  private isBehind(label: Label): boolean {
    return this.picker?.between(this.view.camera.position, label.position) ?? false;
  }
}
