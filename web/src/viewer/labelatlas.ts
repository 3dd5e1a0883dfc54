import { CanvasTexture, LinearFilter } from 'three';
import type { Label } from './label.ts';

/** The size of a picture, in pixels of the page. What it shows lies in its middle. */
export const CELL_WIDTH = 48;
export const CELL_HEIGHT = 28;
const MIDDLE_X = CELL_WIDTH / 2;
const MIDDLE_Y = CELL_HEIGHT / 2;
const DOT = 4.5;

/** The parts of a label: its dot, its number, and the line between them. */
export type LabelPart = 'dot' | 'tag' | 'line';
const COLUMNS = 16;
const ROWS = 48;

/** Pictures of the parts of labels in one texture. A picture is drawn once for each look that occurs, not for each frame. */
export class LabelAtlas {
  readonly texture: CanvasTexture;
  private readonly context: CanvasRenderingContext2D;
  private readonly ratio: number;
  private readonly cells = new Map<string, number>();

  constructor(ratio: number) {
    this.ratio = ratio;
    const canvas = document.createElement('canvas');
    canvas.width = CELL_WIDTH * COLUMNS * ratio;
    canvas.height = CELL_HEIGHT * ROWS * ratio;
    const context = canvas.getContext('2d', { willReadFrequently: true });
    if (!context) throw new Error('this browser cannot draw on a canvas');
    this.context = context;
    this.texture = new CanvasTexture(canvas);
    this.texture.flipY = false;
    // Soft edges keep their colour only if colours are weighted before they are mixed.
    this.texture.premultiplyAlpha = true;
    this.texture.generateMipmaps = false;
    this.texture.minFilter = LinearFilter;
    this.texture.magFilter = LinearFilter;
  }

  /** The column and row of the picture of a part of a label. */
  cell(label: Label, part: LabelPart): [number, number] {
    const key = keyOf(label, part);
    let index = this.cells.get(key);
    if (index === undefined) {
      // A full atlas begins anew; whatever is still on the screen is drawn again as it is asked for.
      if (this.cells.size === COLUMNS * ROWS) this.cells.clear();
      index = this.cells.size;
      this.cells.set(key, index);
      this.draw(label, part, index % COLUMNS, Math.floor(index / COLUMNS));
      this.texture.needsUpdate = true;
    }
    return [index % COLUMNS, Math.floor(index / COLUMNS)];
  }

  get grid(): [number, number] {
    return [COLUMNS, ROWS];
  }

  private draw(label: Label, part: LabelPart, column: number, row: number): void {
    const { context, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, column * CELL_WIDTH * ratio, row * CELL_HEIGHT * ratio);
    context.clearRect(0, 0, CELL_WIDTH, CELL_HEIGHT);
    if (part === 'dot') drawDot(context, label);
    else if (part === 'tag') drawTag(context, label);
    else drawLine(context, label);
  }
}

function keyOf({ text, colour, hollow, selected, hovered }: Label, part: LabelPart): string {
  if (part === 'line') return `line|${colour}`;
  return part === 'dot' ? `dot|${colour}|${hollow}|${selected || hovered}` : `tag|${text}|${colour}|${hollow}`;
}

/** Half the width of the tag of a label, as far as the page needs it to keep tags apart. */
export function halfTag(label: Label): number {
  return Math.max(9, label.text.length * 3.6 + 4.5) + 1;
}

/** The line takes the colour of the middle. The rim stays empty, or it would show as a thin line at the edge of the cells beside it. */
function drawLine(context: CanvasRenderingContext2D, label: Label): void {
  context.fillStyle = label.colour;
  context.fillRect(MIDDLE_X - 4, MIDDLE_Y - 4, 8, 8);
}

function drawDot(context: CanvasRenderingContext2D, label: Label): void {
  if (label.selected || label.hovered) {
    circle(context, DOT + 5);
    context.strokeStyle = '#fff';
    context.lineWidth = 4;
    context.stroke();
    context.strokeStyle = label.colour;
    context.lineWidth = 2;
    context.stroke();
  }
  circle(context, DOT);
  context.fillStyle = label.hollow ? '#fff' : label.colour;
  context.fill();
  context.lineWidth = label.hollow ? 2.5 : 1.5;
  context.strokeStyle = label.hollow ? label.colour : '#fff';
  context.stroke();
}

function circle(context: CanvasRenderingContext2D, radius: number): void {
  context.beginPath();
  context.arc(MIDDLE_X, MIDDLE_Y, radius, 0, 2 * Math.PI);
}

function drawTag(context: CanvasRenderingContext2D, label: Label): void {
  context.font = '600 11px system-ui, "DejaVu Sans", sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  const width = Math.max(context.measureText(label.text).width + 9, 18);
  const [x, y] = [MIDDLE_X, MIDDLE_Y];
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
