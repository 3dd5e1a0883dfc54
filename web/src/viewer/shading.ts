import {
  Color,
  DataTexture,
  DoubleSide,
  FrontSide,
  GLSL3,
  LinearFilter,
  LineBasicMaterial,
  RGBAFormat,
  ShaderMaterial,
  Vector2,
} from 'three';
import { type ColourMapName, colourTable } from './colours.ts';

/** A value that stands for "not known here" and is drawn in the plain colour of the surface. */
export const UNKNOWN_VALUE = -1e30;

const VERTEX = /* glsl */ `
in float value;
in float state;
out vec3 vNormal;
out float vValue;
out float vState;
void main() {
  vNormal = normalMatrix * normal;
  vValue = value;
  vState = state;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
`;

// One light at the left above the eye and one from the sky: cheap enough for graphics in software. Colours are those of the screen.
const FRAGMENT = /* glsl */ `
precision highp float;
in vec3 vNormal;
in float vValue;
in float vState;
uniform vec3 surfaceColour;
uniform vec3 hoverColour;
uniform float opacity;
uniform float coloured;
uniform vec2 range;
uniform sampler2D table;
out vec4 colour;
void main() {
  vec3 n = normalize(vNormal);
  if (!gl_FrontFacing) n = -n;
  vec3 base = surfaceColour;
  float strength = 0.0;
  if (coloured > 0.5 && vValue > -1.0e29) {
    base = texture(table, vec2(clamp((vValue - range.x) / (range.y - range.x), 0.002, 0.998), 0.5)).rgb;
    strength = 1.0;
  }
  base = mix(base, hoverColour, clamp(vState, 0.0, 1.0) * 0.55);
  float key = max(dot(n, vec3(-0.32, 0.62, 0.71)), 0.0);
  float shade = 0.40 + 0.20 * (0.5 + 0.5 * n.y) + 0.46 * key;
  // Colours of values are read against a legend, so they are shaded less.
  shade = mix(shade, 0.62 + 0.42 * key, strength * 0.7);
  float edge = 1.0 - abs(n.z);
  float alpha = opacity < 1.0 ? mix(opacity * 0.6, min(opacity * 2.2, 1.0), edge * edge) : 1.0;
  colour = vec4(base * shade, alpha);
}
`;

export interface SurfaceLook {
  colour: Color;
  hover: Color;
}

export class SurfaceMaterial extends ShaderMaterial {
  private map: ColourMapName | null = null;

  constructor() {
    super({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      uniforms: {
        surfaceColour: { value: new Color(0.7, 0.72, 0.75) },
        hoverColour: { value: new Color(0.3, 0.6, 0.95) },
        opacity: { value: 1 },
        coloured: { value: 0 },
        range: { value: new Vector2(0, 1) },
        table: { value: null },
      },
      // Lines of the wireframe lie on the surface and must win.
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
  }

  setLook(look: SurfaceLook): void {
    this.uniforms.surfaceColour.value.copy(look.colour);
    this.uniforms.hoverColour.value.copy(look.hover);
  }

  setOpacity(opacity: number): void {
    this.uniforms.opacity.value = opacity;
    this.transparent = opacity < 1;
    this.depthWrite = opacity >= 1;
  }

  /** Draws the fronts of triangles only, or both sides. */
  setSides(frontOnly: boolean): void {
    this.side = frontOnly ? FrontSide : DoubleSide;
  }

  /** Colours by the attribute `value`, or by none. */
  setColourMap(map: ColourMapName | null, low = 0, high = 1): void {
    this.uniforms.coloured.value = map ? 1 : 0;
    this.uniforms.range.value.set(low, high > low ? high : low + 1);
    if (!map || map === this.map) return;
    this.map = map;
    this.uniforms.table.value?.dispose();
    const table = new DataTexture(colourTable(map, 256), 256, 1, RGBAFormat);
    table.magFilter = LinearFilter;
    table.minFilter = LinearFilter;
    table.needsUpdate = true;
    this.uniforms.table.value = table;
  }

  override dispose(): void {
    this.uniforms.table.value?.dispose();
    super.dispose();
  }
}

export function lineMaterial(): LineBasicMaterial {
  return new LineBasicMaterial({ transparent: true, opacity: 0.4, toneMapped: false });
}
