// Uniforms that the shaders share.
import {
  type DataArrayTexture, type DataTexture, Matrix4, type Texture, Vector2, Vector3,
} from "three";

/** A value that all materials read which hold the same object. */
export interface Uniform<T> {
  value: T;
}

export type Uniforms = ReturnType<typeof makeUniforms>;

export function makeUniforms(
  poses: DataTexture,
  pieces: DataTexture,
  materials: DataTexture,
  images: DataArrayTexture,
) {
  return {
    poses: { value: poses },
    pieces: { value: pieces },
    materials: { value: materials },
    images: { value: images },
    /** The eye's. */
    eye: { value: new Vector3() },
    view: { value: new Matrix4() },
    projection: { value: new Matrix4() },
    inverseProjection: { value: new Matrix4() },
    viewProjection: { value: new Matrix4() },
    inverseViewProjection: { value: new Matrix4() },
    pixels: { value: new Vector2() },
    distance0: { value: 1 },
    /** The lamp's. */
    lamp: { value: new Vector3() },
    lampMatrix: { value: new Matrix4() },
    lampReach: { value: new Vector3() },
    lampDepth: { value: null as Texture | null },
    glassDepth: { value: null as Texture | null },
    hasGlass: { value: false },
    /** Of the ambient light. */
    ambient: { value: null as Texture | null },
    hasAmbient: { value: true },
    reach: { value: 1 },
    /** Samples of everything that is sampled, and what turns their pattern. */
    taps: { value: 16 },
    seed: { value: 0 },
    /** Of the floor's grid. */
    spacing: { value: 1 },
    gridOrigin: { value: new Vector3() },
  };
}
