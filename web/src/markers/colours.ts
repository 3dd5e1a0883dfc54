/** Twelve colours that tell neighbours apart on grey and on coloured meshes; white text is readable on all of them. */
const COLOURS = [
  '#1d6fd1',
  '#c2410c',
  '#15803d',
  '#9333ea',
  '#be123c',
  '#0f766e',
  '#a16207',
  '#4f46e5',
  '#a21caf',
  '#4d7c0f',
  '#b45309',
  '#0e7490',
];

export function pairColour(index: number): string {
  return COLOURS[((index % COLOURS.length) + COLOURS.length) % COLOURS.length];
}
