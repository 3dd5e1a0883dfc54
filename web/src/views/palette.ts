import { Color } from 'three';
import type { Theme } from '../ui/theme.ts';
import type { SurfaceLook } from '../viewer/shading.ts';

interface Palette {
  background: Color;
  line: Color;
  gap: Color;
  source: SurfaceLook;
  target: SurfaceLook;
  ghost: SurfaceLook;
}

const hover = new Color('#4c9aff');

const LIGHT: Palette = {
  background: new Color('#eceff2'),
  line: new Color('#1f2933'),
  gap: new Color('#d9dde2'),
  source: { colour: new Color('#cfd3d8'), hover },
  target: { colour: new Color('#d8cfc4'), hover },
  ghost: { colour: new Color('#5aa9e6'), hover },
};

const DARK: Palette = {
  background: new Color('#17191d'),
  // Lines that lie close must not turn the mesh into the background.
  line: new Color('#6d7683'),
  gap: new Color('#353a41'),
  source: { colour: new Color('#aeb4bd'), hover },
  target: { colour: new Color('#bdb2a4'), hover },
  ghost: { colour: new Color('#4f9bd8'), hover },
};

export function paletteOf(theme: Theme): Palette {
  return theme === 'dark' ? DARK : LIGHT;
}
