import type { Vector3 } from 'three';

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
  /** Shows a place only: it cannot be grabbed. */
  passive?: boolean;
  /** From 1 to 0 while it fades. */
  strength?: number;
}
