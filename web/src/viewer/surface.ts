import {
  BufferAttribute,
  BufferGeometry,
  type Color,
  DynamicDrawUsage,
  Group,
  type LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  Sphere,
  Vector3,
} from 'three';
import { isSolid } from './closed.ts';
import { coarseTriangles } from './coarse.ts';
import type { ColourMapName } from './colours.ts';
import { type Frame, frameOf, type Up, unitMatrix } from './frame.ts';
import { computeNormals, representatives } from './normals.ts';
import { lineMaterial, type SurfaceLook, SurfaceMaterial, UNKNOWN_VALUE } from './shading.ts';

export interface MeshData {
  positions: Float32Array;
  triangles: Uint32Array;
  /** The component of each triangle. */
  components: Uint32Array;
  /** Equal numbers for copies of a vertex along a seam. */
  welded: Uint32Array;
  /** Edges of the polygons, two vertices each. */
  edges: Uint32Array;
}

const COARSE_ABOVE = 30_000;
const COARSE_CELLS = 90;

/** A mesh on the screen, whose positions change in place. */
export class Surface {
  readonly group = new Group();
  readonly geometry = new BufferGeometry();
  readonly positions: Float32Array;
  readonly rest: Float32Array;
  readonly triangles: Uint32Array;
  readonly components: Uint32Array;
  readonly vertexComponents: Uint32Array;
  frame: Frame;
  readonly matrix = new Matrix4();
  readonly inverse = new Matrix4();
  /** Counts changes of positions, for what is derived from them. */
  version = 0;
  private readonly material = new SurfaceMaterial();
  private readonly mesh: Mesh;
  private lines: LineSegments | null = null;
  private readonly representative: Uint32Array;
  /** Whether the backs of triangles are never seen. */
  private readonly solid: boolean;
  private readonly edges: Uint32Array;
  /** The array that the positions were last taken from. */
  private shown: Float32Array | null = null;
  private anyTinted = false;
  private coloured = false;
  private full: BufferAttribute;
  private coarse: BufferAttribute | null = null;
  private lineColour: Color | null = null;
  private hidden: ReadonlySet<number> = new Set();

  constructor(data: MeshData, up: Up = 'y') {
    this.rest = data.positions;
    this.positions = data.positions.slice();
    this.triangles = data.triangles;
    this.components = data.components;
    this.edges = data.edges;
    this.vertexComponents = componentsOfVertices(data);
    this.representative = representatives(data.welded);
    const count = data.positions.length / 3;
    const position = new BufferAttribute(this.positions, 3).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute('position', position);
    this.geometry.setAttribute(
      'normal',
      new BufferAttribute(new Float32Array(count * 3), 3).setUsage(DynamicDrawUsage),
    );
    this.geometry.setAttribute('value', new BufferAttribute(new Float32Array(count), 1).setUsage(DynamicDrawUsage));
    this.geometry.setAttribute('state', new BufferAttribute(new Float32Array(count), 1).setUsage(DynamicDrawUsage));
    this.full = new BufferAttribute(data.triangles, 1);
    this.geometry.setIndex(this.full);
    // The whole mesh is in sight nearly always, so nothing is gained by testing whether it is.
    this.geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    this.mesh = new Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false;
    this.group.add(this.mesh);
    this.group.matrixAutoUpdate = false;
    this.frame = frameOf(data.positions, up);
    this.setUp(up);
    this.updateNormals();
    this.solid = isSolid(data.positions, data.triangles, data.components, this.representative);
    this.material.setSides(this.solid);
  }

  setUp(up: Up): void {
    this.frame = { ...this.frame, up };
    this.placeIn(this.frame);
  }

  /** Draws the mesh in the unit frame of another one, for meshes that are compared. */
  placeIn(frame: Frame): void {
    this.frame = frame;
    this.matrix.copy(unitMatrix(frame));
    this.inverse.copy(this.matrix).invert();
    this.group.matrix.copy(this.matrix);
    this.group.updateMatrixWorld(true);
  }

  /** Shows other positions; tells whether they are others. */
  setPositions(positions: Float32Array): boolean {
    if (positions === this.shown) return false;
    this.shown = positions;
    // A result often is the preview once more. To compare costs far less than to draw.
    if (sameNumbers(positions, this.positions)) return false;
    this.positions.set(positions.length === this.positions.length ? positions : this.rest);
    this.geometry.attributes.position.needsUpdate = true;
    this.updateNormals();
    this.version += 1;
    return true;
  }

  /** Sets values of vertices, NaN for unknown ones, and the colours that stand for them; null for the plain colour. Tells whether the picture changes. */
  setValues(values: Float32Array | null, map: ColourMapName = 'error', low = 0, high = 1): boolean {
    if (!values && !this.coloured) return false;
    this.coloured = values !== null;
    if (values) {
      const attribute = this.geometry.attributes.value as BufferAttribute;
      const array = attribute.array as Float32Array;
      for (let i = 0; i < array.length; i++) array[i] = Number.isFinite(values[i]) ? values[i] : UNKNOWN_VALUE;
      attribute.needsUpdate = true;
    }
    this.material.setColourMap(values ? map : null, low, high);
    return true;
  }

  /** Tints components, e.g. the one below the pointer. */
  tint(components: ReadonlySet<number>): void {
    const attribute = this.geometry.attributes.state as BufferAttribute;
    // The usual case costs nothing: no component is tinted, and none was.
    if (components.size === 0 && !this.anyTinted) return;
    this.anyTinted = components.size > 0;
    const { vertexComponents } = this;
    for (let v = 0; v < vertexComponents.length; v++) attribute.array[v] = components.has(vertexComponents[v]) ? 1 : 0;
    attribute.needsUpdate = true;
  }

  hide(components: ReadonlySet<number>): void {
    if (components === this.hidden) return;
    this.hidden = components;
    this.full = new BufferAttribute(this.visible(this.triangles, 3), 1);
    this.coarse = null;
    this.geometry.setIndex(this.full);
    if (this.lines) this.lines.geometry.setIndex(new BufferAttribute(this.visible(this.edges, 2), 1));
  }

  /** Draws fewer triangles, while a machine cannot turn all of them smoothly. */
  setCoarse(coarse: boolean): void {
    if (coarse && this.triangles.length / 3 > COARSE_ABOVE) {
      this.coarse ??= new BufferAttribute(this.visible(coarseTriangles(this.rest, this.triangles, COARSE_CELLS), 3), 1);
      if (this.geometry.index !== this.coarse) this.geometry.setIndex(this.coarse);
    } else if (this.geometry.index !== this.full) this.geometry.setIndex(this.full);
  }

  isHidden(triangle: number): boolean {
    return this.hidden.size > 0 && this.hidden.has(this.components[triangle]);
  }

  get anyHidden(): boolean {
    return this.hidden.size > 0;
  }

  setLook(look: SurfaceLook, line: Color): void {
    this.material.setLook(look);
    if (this.lines) (this.lines.material as LineBasicMaterial).color.copy(line);
    this.lineColour = line;
  }

  setOpacity(opacity: number): void {
    this.material.setOpacity(opacity);
    this.material.setSides(this.solid && opacity >= 1);
    // Transparent surfaces come last, so that what lies within them is seen.
    this.mesh.renderOrder = opacity < 1 ? 1 : 0;
  }

  setWireframe(shown: boolean): void {
    if (shown && !this.lines) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', this.geometry.attributes.position);
      geometry.setIndex(new BufferAttribute(this.visible(this.edges, 2), 1));
      const material = lineMaterial();
      if (this.lineColour) material.color.copy(this.lineColour);
      this.lines = new LineSegments(geometry, material);
      this.lines.frustumCulled = false;
      this.group.add(this.lines);
      this.lines.updateMatrixWorld(true);
    }
    if (this.lines) this.lines.visible = shown;
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
    this.lines?.geometry.dispose();
    (this.lines?.material as LineBasicMaterial | undefined)?.dispose();
    this.group.removeFromParent();
  }

  private updateNormals(): void {
    const normal = this.geometry.attributes.normal as BufferAttribute;
    computeNormals(this.positions, this.triangles, this.representative, normal.array as Float32Array);
    normal.needsUpdate = true;
  }

  /** The triangles or edges, `size` vertices each, that no hidden component holds. */
  private visible(elements: Uint32Array, size: number): Uint32Array {
    if (this.hidden.size === 0) return elements;
    const result = new Uint32Array(elements.length);
    let count = 0;
    for (let i = 0; i < elements.length; i += size) {
      if (this.hidden.has(this.vertexComponents[elements[i]])) continue;
      for (let corner = 0; corner < size; corner++) result[count++] = elements[i + corner];
    }
    return result.slice(0, count);
  }
}

function sameNumbers(a: Float32Array, b: Float32Array): boolean {
  if (a.length !== b.length) return false;
  for (let i = 0; i < a.length; i++) if (a[i] !== b[i]) return false;
  return true;
}

const NO_COMPONENT = 0xffffffff;

function componentsOfVertices(data: MeshData): Uint32Array {
  const result = new Uint32Array(data.positions.length / 3).fill(NO_COMPONENT);
  for (let corner = 0; corner < data.triangles.length; corner++) {
    result[data.triangles[corner]] = data.components[Math.floor(corner / 3)];
  }
  return result;
}
