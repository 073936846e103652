// Draws the bodies at a time: shadows, ambient occlusion, surfaces, glass, film. The stage's origin
// is the first target.
import {
  CustomBlending, type DataArrayTexture, DoubleSide, DstColorFactor, GLSL3, HalfFloatType, Matrix4,
  Mesh, OneFactor, type PerspectiveCamera,
  PlaneGeometry, Quaternion, RawShaderMaterial, Scene, type ShaderMaterialParameters, Vector3, type
  WebGLRenderer,
  WebGLRenderTarget, ZeroFactor,
} from "three";
import { Film } from "./film";
import { Geometries, isSkinned, materialTable, numbers, pieceTable, table } from "./geometry";
import { Lamp } from "./lamp";
import { Occlusion } from "./occlusion";
import { TEXELS } from "./poses";
import type { Footage } from "./recording";
import { BACKDROP_FRAGMENT, FLOOR_FRAGMENT, FLOOR_VERTEX, SURFACE_FRAGMENT } from "./shaders/light";
import { SURFACE_VERTEX } from "./shaders/place";
import { SCREEN_VERTEX } from "./shaders/screen";
import { type Uniform, type Uniforms, makeUniforms } from "./uniforms";

/**
 * Half the width of what is drawn of a half-space, over the camera's distance: it ends in the haze.
 */
const FLOOR_REACH = 40;

/**
 * Details that are left out where it is coarse, over half the height of the first view: three
 * pixels of a picture 360 high. Of `rain-100` half the triangles are left then, and of two pixels
 * all but a few.
 */
const COARSE = 6 / 360;

/** How much is spent on a picture. */
export interface Quality {
  /** Samples of shadows and of ambient light. */
  taps: number;
  ambient: boolean;
  /** Samples of each pixel's outlines. */
  samples: number;
  /** Texels of the shadow map along a side. */
  shadow: number;
  /** Whether details are left out, unless they are looked at from near. */
  isCoarse: boolean;
}

export class Stage {
  readonly uniforms: Uniforms;
  /** By how much of the height the target is drawn above the middle. */
  raised = 0;
  private readonly geometries: Geometries;
  private readonly glass: Mesh[] = [];
  /** So many bodies have been born at the time shown. */
  private born = 0;
  /** Whether the driver has all programs. */
  private isComplete = false;
  /** Of the first view [m]. */
  private distance0 = 1;
  private readonly scene = new Scene();
  private readonly lamp: Lamp;
  private readonly occlusion: Occlusion;
  private readonly film: Film;
  private readonly target = new WebGLRenderTarget(1, 1, { type: HalfFloatType, samples: 4 });
  private readonly floors: {
    mesh: Mesh;
    body: number;
    matrix: Uniform<Matrix4>;
    normal: Uniform<Vector3>;
  }[] = [];

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly footage: Footage,
    images: DataArrayTexture,
    camera: PerspectiveCamera,
  ) {
    this.uniforms = makeUniforms(table(1), table(1), table(1), images);
    this.geometries = new Geometries(isSkinned(footage));
    const skinned: Record<string, string> = this.geometries.skinned ? { SKINNED: "" } : {};
    const right = new Vector3(1, 0, 0).applyQuaternion(camera.quaternion);
    this.lamp = new Lamp(this.geometries, right, this.uniforms);
    this.occlusion = new Occlusion(renderer, this.geometries.solid, this.uniforms);
    this.film = new Film(renderer);

    this.add(
      new Mesh(
        this.geometries.solid,
        this.material(SURFACE_VERTEX, SURFACE_FRAGMENT, { side: DoubleSide, defines: skinned }),
      ),
      0,
    );
    const backdrop = this.material(SCREEN_VERTEX, BACKDROP_FRAGMENT, { depthWrite: false });
    this.add(new Mesh(new PlaneGeometry(2, 2), backdrop), 2);

    // Glass dims what lies behind it, then adds its own light: in which order panes are drawn makes
    // no difference.
    const layers = [
      { defines: { ...skinned, GLASS: 1 }, blendSrc: DstColorFactor, blendDst: ZeroFactor },
      { defines: { ...skinned, GLASS: 2 }, blendSrc: OneFactor, blendDst: OneFactor },
    ] as const;
    layers.forEach((layer, index) => {
      const rest = {
        ...layer,
        side: DoubleSide,
        depthWrite: false,
        blending: CustomBlending,
      } as const;
      const mesh = new Mesh(
        this.geometries.glass,
        this.material(SURFACE_VERTEX, SURFACE_FRAGMENT, rest),
      );
      this.glass.push(mesh);
      this.add(mesh, 3 + index);
    });
    this.takeIn();
    // All that the first picture needs, so that the driver compiles it at once.
    for (const mesh of this.scene.children) if (mesh.visible) renderer.compile(mesh, camera);
    this.lamp.compile(renderer);
    this.film.compile();
  }

  /** Draw all bodies of the footage from now on, those too that are new. */
  takeIn(): void {
    const { footage, uniforms } = this;
    const { eye, target, fieldOfView } = footage.camera;
    this.distance0 = Math.hypot(...eye.map((part, axis) => part - target[axis]!));
    this.geometries.fill(
      footage,
      COARSE * this.distance0 * Math.tan((fieldOfView * Math.PI) / 360),
    );
    uniforms.hasGlass.value = this.geometries.hasGlass;
    for (const mesh of this.glass) mesh.visible = this.geometries.hasGlass;
    const tables = [
      [uniforms.poses, table(TEXELS * footage.bodies.length)],
      [uniforms.pieces, pieceTable(footage)],
      [uniforms.materials, materialTable(footage)],
    ] as const;
    for (const [uniform, texture] of tables) {
      uniform.value.dispose();
      uniform.value = texture;
    }
    footage.bodies.forEach((body, index) => {
      if (body.floor && this.floors.every((floor) => floor.body !== index)) this.addFloor(index);
    });
  }

  /** Let go of all that the driver holds. */
  dispose(): void {
    this.scene.traverse((object) => object instanceof Mesh && object.material.dispose());
    this.geometries.solid.dispose();
    this.geometries.glass.dispose();
    for (const { value } of [this.uniforms.poses, this.uniforms.pieces, this.uniforms.materials])
      value.dispose();
    for (const part of [this.lamp, this.occlusion, this.film, this.target]) part.dispose();
  }

  /** Width and height in pixels. */
  resize(width: number, height: number): void {
    this.target.setSize(width, height);
    this.occlusion.resize(width, height);
    this.film.resize(width, height);
    this.uniforms.pixels.value.set(width, height);
  }

  /** Move the bodies to a time in frames, pulled apart so far. */
  pose(time: number, explode: number): void {
    const poses = this.uniforms.poses.value;
    this.footage.fill(time, explode, this.footage.camera.target, numbers(poses));
    poses.needsUpdate = true;
    // Bodies are in the order of their birth; pieces are seen on the way to it.
    const { bodies } = this.footage;
    let [low, high] = [0, bodies.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (bodies[middle]!.birth <= Math.floor(time) + 1) low = middle + 1;
      else high = middle;
    }
    this.born = low;
  }

  /** Draw; of several pictures of the same, number them from 0, and each smooths those before. */
  draw(camera: PerspectiveCamera, target: Vector3, quality: Quality, picture: number): void {
    const { uniforms } = this;
    const distance = camera.position.distanceTo(target);
    const [width, height] = uniforms.pixels.value.toArray() as [number, number];
    const [x, y] =
      picture === 0
        ? [0, 0]
        : [((picture * 0.7548776662466927) % 1) - 0.5, ((picture * 0.5698402909980532) % 1) - 0.5];
    camera.setViewOffset(width, height, x, y + this.raised * height, width, height);
    camera.updateMatrixWorld();
    uniforms.eye.value.copy(camera.position);
    uniforms.view.value.copy(camera.matrixWorldInverse);
    uniforms.projection.value.copy(camera.projectionMatrix);
    uniforms.inverseProjection.value.copy(camera.projectionMatrixInverse);
    uniforms.viewProjection.value.multiplyMatrices(
      camera.projectionMatrix,
      camera.matrixWorldInverse,
    );
    uniforms.inverseViewProjection.value.copy(uniforms.viewProjection.value).invert();
    uniforms.taps.value = quality.taps;
    uniforms.seed.value = (picture * 0.618033988749895) % 1;
    uniforms.hasAmbient.value = quality.ambient;
    uniforms.reach.value = 0.09 * distance;
    uniforms.distance0.value = distance;
    uniforms.spacing.value = 10 ** Math.max(Math.ceil(Math.log10(distance / 30)), -6);
    uniforms.gridOrigin.value.fromArray(
      this.footage.camera.target.map((part) => part % uniforms.spacing.value),
    );

    if (this.target.samples !== quality.samples) {
      this.target.dispose();
      this.target.samples = quality.samples;
    }
    this.lamp.resize(quality.shadow);
    this.geometries.choose(
      quality.isCoarse && this.geometries.isLarge && distance > 0.6 * this.distance0,
      this.born,
    );
    this.lamp.draw(this.renderer, target, distance, uniforms);
    this.placeFloors(target, distance);
    if (quality.ambient) this.occlusion.draw(camera);
    this.renderer.setRenderTarget(this.target);
    this.renderer.clear();
    this.renderer.render(this.scene, camera);
    this.film.show(this.target.texture, picture);
    // Better pictures come later.
    if (!this.isComplete) this.occlusion.compile(camera);
    this.isComplete = true;
  }

  private add(mesh: Mesh, order: number): void {
    mesh.frustumCulled = false;
    mesh.renderOrder = order;
    this.scene.add(mesh);
  }

  private material(
    vertexShader: string,
    fragmentShader: string,
    rest: ShaderMaterialParameters,
  ): RawShaderMaterial {
    return new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader,
      fragmentShader,
      uniforms: { ...this.uniforms },
      ...rest,
    });
  }

  private addFloor(body: number): void {
    const matrix = { value: new Matrix4() };
    const normal = { value: new Vector3() };
    const material = this.material(FLOOR_VERTEX, FLOOR_FRAGMENT, { side: DoubleSide });
    Object.assign(material.uniforms, { floorMatrix: matrix, floorNormal: normal });
    const mesh = new Mesh(new PlaneGeometry(2, 2).rotateX(-Math.PI / 2), material);
    this.add(mesh, 1);
    this.floors.push({ mesh, body, matrix, normal });
  }

  /** Half-spaces are shown around what the camera looks at. */
  private placeFloors(target: Vector3, distance: number): void {
    const poses = numbers(this.uniforms.poses.value);
    for (const { mesh, body, matrix, normal } of this.floors) {
      const at = 4 * TEXELS * body;
      mesh.visible = poses[at + 3] === 1;
      const turn = new Quaternion().fromArray(poses, at + 4);
      normal.value.set(0, 1, 0).applyQuaternion(turn);
      const place = target
        .clone()
        .sub(new Vector3().fromArray(poses, at))
        .projectOnPlane(normal.value)
        .add(new Vector3().fromArray(poses, at));
      const size = FLOOR_REACH * distance;
      matrix.value.compose(place, turn, new Vector3(size, size, size));
    }
  }
}
