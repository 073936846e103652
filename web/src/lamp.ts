// The lamp: where it is, and what it sees, which is all that it lights.
import {
  DepthTexture, DoubleSide, FloatType, GLSL3, Matrix4, Mesh, NearestFilter, OrthographicCamera,
  RawShaderMaterial, Scene,
  Vector3, type WebGLRenderer, WebGLRenderTarget,
} from "three";
import type { Geometries } from "./geometry";
import { LAMP_FRAGMENT, LAMP_VERTEX } from "./shaders/place";
import type { Uniforms } from "./uniforms";

/** Towards the lamp, over the right shoulder of the first view (right, up, back). */
const TOWARDS = [0.7, 1.15, 0.65] as const;
/** Half the width of what the lamp sees, and how far to each side, over the camera's distance. */
const REACH = 0.95;
const DEPTH = 5;

export class Lamp {
  /** Unit vector towards it. */
  readonly towards: Vector3;
  private readonly camera = new OrthographicCamera();
  /** Of a shadow map along a side. */
  private texels = 1;
  private readonly maps: { target: WebGLRenderTarget; scene: Scene }[] = [];

  constructor(geometries: Geometries, right: Vector3, uniforms: Uniforms) {
    const up = new Vector3(0, 1, 0);
    this.towards = right.clone().multiplyScalar(TOWARDS[0]).addScaledVector(up, TOWARDS[1]);
    this.towards.addScaledVector(new Vector3().crossVectors(right, up), TOWARDS[2]).normalize();
    uniforms.lamp.value.copy(this.towards);
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: LAMP_VERTEX,
      fragmentShader: LAMP_FRAGMENT,
      uniforms: { poses: uniforms.poses, lampMatrix: uniforms.lampMatrix },
      side: DoubleSide,
    });
    for (const geometry of [geometries.solid, geometries.glass]) {
      const target = new WebGLRenderTarget(1, 1, { depthTexture: depthTexture(1, 1) });
      const scene = new Scene();
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      scene.add(mesh);
      this.maps.push({ target, scene });
    }
    uniforms.lampDepth.value = this.maps[0]!.target.depthTexture;
    uniforms.glassDepth.value = this.maps.at(-1)!.target.depthTexture;
  }

  /** Texels of the shadow maps along a side. */
  resize(texels: number): void {
    if (texels === this.texels) return;
    this.texels = texels;
    for (const { target } of this.maps) target.setSize(texels, texels);
  }

  /** Let the driver compile beside the page. */
  compile(renderer: WebGLRenderer): void {
    renderer.compile(this.maps[0]!.scene, this.camera);
  }

  /** Look at what the camera looks at, from its distance [m], and draw what casts shadows. */
  draw(renderer: WebGLRenderer, target: Vector3, distance: number, uniforms: Uniforms): void {
    const reach = REACH * distance;
    const depth = DEPTH * distance;
    Object.assign(this.camera, {
      left: -reach,
      right: reach,
      top: reach,
      bottom: -reach,
      near: 0,
      far: 2 * depth,
    });
    this.camera.position.copy(target).addScaledVector(this.towards, depth);
    this.camera.lookAt(target);
    this.camera.updateMatrixWorld();
    this.camera.updateProjectionMatrix();
    uniforms.lampMatrix.value.copy(
      this.onTexels(
        new Matrix4().multiplyMatrices(
          this.camera.projectionMatrix,
          this.camera.matrixWorldInverse,
        ),
      ),
    );
    uniforms.lampReach.value.set(reach, 2 * depth, (2 * reach) / this.texels);
    for (const { target: map, scene } of uniforms.hasGlass.value
      ? this.maps
      : this.maps.slice(0, 1)) {
      renderer.setRenderTarget(map);
      renderer.clear();
      renderer.render(scene, this.camera);
    }
  }

  dispose(): void {
    for (const { target } of this.maps) target.dispose();
  }

  /** The matrix, moved by less than a texel, so that shadows do not crawl when the camera moves. */
  private onTexels(matrix: Matrix4): Matrix4 {
    const origin = new Vector3().applyMatrix4(matrix).multiplyScalar(this.texels / 2);
    const rest = [Math.round(origin.x) - origin.x, Math.round(origin.y) - origin.y].map(
      (part) => (part * 2) / this.texels,
    ) as [number, number];
    return matrix.premultiply(new Matrix4().makeTranslation(...rest, 0));
  }
}

/** Depths that shaders read. */
export function depthTexture(width: number, height: number): DepthTexture {
  const texture = new DepthTexture(width, height, FloatType);
  texture.minFilter = texture.magFilter = NearestFilter;
  return texture;
}
