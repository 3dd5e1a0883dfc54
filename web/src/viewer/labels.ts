import type { Vector3 } from 'three';
import type { View } from './view.ts';

/** A numbered point on a mesh. */
export interface Label {
  id: number;
  text: string;
  colour: string;
  /** The place and the normal there, in the unit frame. */
  position: Vector3;
  normal: Vector3;
  /** Proposed points are hollow, confirmed ones filled. */
  hollow: boolean;
  faint: boolean;
  selected: boolean;
  hovered: boolean;
}

const DOT = 4.5;
const TAG_OFFSET = 13;
const GRAB_RADIUS = 11;

interface Place {
  label: Label;
  x: number;
  y: number;
  hidden: boolean;
}

/** Draws the labels of a view, whose upper left corner is the origin of the context. Those behind the mesh come first and faintly. */
export function drawLabels(context: CanvasRenderingContext2D, view: View, settled: boolean): void {
  const places = placesOf(view, settled);
  places.sort((a, b) => Number(b.hidden) - Number(a.hidden) || rank(a.label) - rank(b.label));
  context.font = '600 11px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (const place of places) drawLabel(context, place);
}

function placesOf(view: View, settled: boolean): Place[] {
  const places: Place[] = [];
  for (const label of view.labels) {
    const pixel = view.project(label.position);
    if (!pixel) continue;
    // An exact test costs a ray for each label, so a moving camera makes do with the side that faces it.
    const toEye = view.camera.position.clone().sub(label.position);
    const away = toEye.dot(label.normal) < 0;
    const hidden = settled && view.occluded ? view.occluded(label) : away;
    places.push({ label, x: pixel[0], y: pixel[1], hidden });
  }
  return places;
}

function rank(label: Label): number {
  return (label.selected ? 2 : 0) + (label.hovered ? 1 : 0);
}

function drawLabel(context: CanvasRenderingContext2D, { label, x, y, hidden }: Place): void {
  context.globalAlpha = hidden ? (label.selected ? 0.55 : 0.22) : label.faint ? 0.5 : 1;
  if (label.selected || label.hovered) {
    context.beginPath();
    context.arc(x, y, DOT + 5, 0, 2 * Math.PI);
    context.strokeStyle = '#fff';
    context.lineWidth = 4;
    context.stroke();
    context.strokeStyle = label.colour;
    context.lineWidth = 2;
    context.stroke();
  }
  context.beginPath();
  context.arc(x, y, DOT, 0, 2 * Math.PI);
  context.fillStyle = label.hollow ? '#fff' : label.colour;
  context.fill();
  context.lineWidth = label.hollow ? 2.5 : 1.5;
  context.strokeStyle = label.hollow ? label.colour : '#fff';
  context.stroke();
  drawTag(context, label, x + TAG_OFFSET, y - TAG_OFFSET);
  context.globalAlpha = 1;
}

function drawTag(context: CanvasRenderingContext2D, label: Label, x: number, y: number): void {
  const width = Math.max(context.measureText(label.text).width + 9, 18);
  context.beginPath();
  context.roundRect(x - width / 2, y - 8, width, 16, 8);
  context.fillStyle = label.hollow ? '#fff' : label.colour;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = label.hollow ? label.colour : '#ffffffd0';
  context.stroke();
  context.fillStyle = label.hollow ? '#1a1d21' : '#fff';
  context.fillText(label.text, x, y + 0.5);
}

/** The label at a pixel of the view; of several, the nearest that is in sight. */
export function labelAt(view: View, x: number, y: number): Label | null {
  let best: Label | null = null;
  let least = Infinity;
  for (const place of placesOf(view, true)) {
    const toDot = Math.hypot(place.x - x, place.y - y);
    const toTag = Math.hypot(place.x + TAG_OFFSET - x, place.y - TAG_OFFSET - y);
    const distance = Math.min(toDot, toTag);
    const score = distance + (place.hidden ? GRAB_RADIUS : 0);
    if (distance <= GRAB_RADIUS && score < least) {
      least = score;
      best = place.label;
    }
  }
  return best;
}
