import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  DynamicDrawUsage,
  GLSL3,
  Mesh,
  OrthographicCamera,
  Scene,
  ShaderMaterial,
  Vector2,
  type WebGLRenderer,
} from 'three';
import type { Label } from './label.ts';
import { CELL_HEIGHT, CELL_WIDTH, halfTag, LabelAtlas, type LabelPart } from './labelatlas.ts';
import { spread, type TagPlace, USUAL_PLACE } from './spread.ts';
import type { View } from './view.ts';

interface Place {
  label: Label;
  x: number;
  y: number;
  hidden: boolean;
}

const GRAB_RADIUS = 11;
const MOST_LABELS = 2048;
/** A line, a dot and a tag for each label. */
const MOST_QUADS = 3 * MOST_LABELS;
const HALF_LINE = 0.9;

const VERTEX = /* glsl */ `
in vec3 corner;
in vec2 cell;
uniform vec2 size;
out vec2 place;
out float strength;
void main() {
  place = cell;
  strength = corner.z;
  gl_Position = vec4(corner.x / size.x * 2.0 - 1.0, 1.0 - corner.y / size.y * 2.0, 0.0, 1.0);
}
`;

const FRAGMENT = /* glsl */ `
precision mediump float;
in vec2 place;
in float strength;
uniform sampler2D atlas;
out vec4 colour;
void main() {
  colour = texture(atlas, place) * strength;
}
`;

/** Draws labels over a view with the renderer of the meshes: a second canvas over the first would cost as much as all triangles. */
export class LabelPainter {
  private readonly atlas: LabelAtlas;
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly geometry = new BufferGeometry();
  private readonly material: ShaderMaterial;
  private readonly corners = new Float32Array(MOST_QUADS * 12);
  private count = 0;
  private readonly cells = new Float32Array(MOST_QUADS * 8);

  constructor(ratio: number) {
    this.atlas = new LabelAtlas(ratio);
    this.geometry.setAttribute('corner', new BufferAttribute(this.corners, 3).setUsage(DynamicDrawUsage));
    this.geometry.setAttribute('cell', new BufferAttribute(this.cells, 2).setUsage(DynamicDrawUsage));
    this.geometry.setIndex(new BufferAttribute(quads(MOST_QUADS), 1));
    this.material = new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { atlas: { value: this.atlas.texture }, size: { value: new Vector2() } },
      transparent: true,
      premultipliedAlpha: true,
      depthTest: false,
      depthWrite: false,
      side: DoubleSide,
    });
    const mesh = new Mesh(this.geometry, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  draw(renderer: WebGLRenderer, view: View, settled: boolean): void {
    const places = placesOf(view, settled).slice(-MOST_LABELS);
    if (places.length === 0) return;
    // Later ones lie over earlier ones: what is hidden comes first, what is selected last.
    places.sort((a, b) => Number(b.hidden) - Number(a.hidden) || rank(a.label) - rank(b.label));
    placeTags(view, places);
    this.count = 0;
    const [hidden, seen] = [places.filter((place) => place.hidden), places.filter((place) => !place.hidden)];
    // No dot and no line of a label that is seen covers the number of another.
    for (const group of [hidden, seen]) {
      for (const part of ['line', 'dot', 'tag'] as const) for (const place of group) this.write(view, place, part);
    }
    for (const name of ['corner', 'cell']) {
      const attribute = this.geometry.attributes[name] as BufferAttribute;
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, this.count * 4 * attribute.itemSize);
      attribute.needsUpdate = true;
    }
    this.geometry.setDrawRange(0, this.count * 6);
    this.material.uniforms.size.value.set(view.width, view.height);
    renderer.render(this.scene, this.camera);
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
    this.atlas.texture.dispose();
  }

  private write(view: View, { label, x, y, hidden }: Place, part: LabelPart): void {
    const { dx, dy, led } = view.tags.get(label.id) ?? USUAL_PLACE;
    if (part === 'line' && !led) return;
    const [column, row] = this.atlas.cell(label, part);
    const [columns, rows] = this.atlas.grid;
    const shown = hidden ? (label.selected ? 0.55 : 0.22) : label.faint ? 0.5 : 1;
    const strength = shown * (label.strength ?? 1);
    const index = this.count;
    this.count += 1;
    if (part === 'line') {
      const scale = HALF_LINE / Math.hypot(dx, dy);
      const [u, v] = [-dy * scale, dx * scale];
      const ends = [x + u, y + v, strength, x + dx + u, y + dy + v, strength];
      this.corners.set([...ends, x - u, y - v, strength, x + dx - u, y + dy - v, strength], index * 12);
      const middle = [(column + 0.5) / columns, (row + 0.5) / rows];
      this.cells.set([...middle, ...middle, ...middle, ...middle], index * 8);
      return;
    }
    // Whole pixels keep the digits sharp.
    const [middleX, middleY] = part === 'tag' ? [x + dx, y + dy] : [x, y];
    const [left, top] = [Math.round(middleX - CELL_WIDTH / 2), Math.round(middleY - CELL_HEIGHT / 2)];
    for (let corner = 0; corner < 4; corner++) {
      const [right, down] = [corner & 1, corner >> 1];
      this.corners.set([left + right * CELL_WIDTH, top + down * CELL_HEIGHT, strength], index * 12 + corner * 3);
      this.cells.set([(column + right) / columns, (row + down) / rows], index * 8 + corner * 2);
    }
  }
}

/** Keeps the tags of labels in sight apart; the selected one chooses first, and one that only shows a place last. */
function placeTags(view: View, places: readonly Place[]): void {
  const first = ({ label }: Place) => (label.passive ? -1 : rank(label));
  const spots = places
    .filter(({ label, hidden }) => !hidden || label.selected)
    .sort((a, b) => first(b) - first(a) || a.label.id - b.label.id)
    .map(({ label, x, y }) => ({ id: label.id, x, y, half: halfTag(label) }));
  view.tags = spread(spots, view.tags);
}

function quads(count: number): Uint16Array {
  const index = new Uint16Array(count * 6);
  for (let i = 0; i < count; i++)
    index.set(
      [0, 2, 1, 1, 2, 3].map((corner) => i * 4 + corner),
      i * 6,
    );
  return index;
}

function placesOf(view: View, settled: boolean): Place[] {
  const places: Place[] = [];
  for (const label of view.labels) {
    const pixel = view.project(label.position);
    if (!pixel) continue;
    // An exact test costs a ray for each label, so a moving camera makes do with the side that faces it.
    const toEye = view.camera.position.clone().sub(label.position);
    const away = toEye.dot(label.normal) < 0;
    const hidden = !view.transparent && (settled && view.occluded ? view.occluded(label) : away);
    places.push({ label, x: pixel[0], y: pixel[1], hidden });
  }
  return places;
}

function rank(label: Label): number {
  return (label.selected ? 2 : 0) + (label.hovered ? 1 : 0);
}

/** The label at a pixel of the view; of several, the nearest that is in sight. */
export function labelAt(view: View, x: number, y: number): Label | null {
  let best: Label | null = null;
  let least = Infinity;
  for (const place of placesOf(view, true).filter((other) => !other.label.passive)) {
    const toDot = Math.hypot(place.x - x, place.y - y);
    const { dx, dy }: TagPlace = view.tags.get(place.label.id) ?? USUAL_PLACE;
    const toTag = Math.hypot(place.x + dx - x, place.y + dy - y);
    const distance = Math.min(toDot, toTag);
    const score = distance + (place.hidden ? GRAB_RADIUS : 0);
    if (distance <= GRAB_RADIUS && score < least) {
      least = score;
      best = place.label;
    }
  }
  return best;
}
