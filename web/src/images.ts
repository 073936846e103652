// The images of a recording, as layers of one texture: materials differ by the layer, not by the
// draw call.
import { DataArrayTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping } from "three";
import type { Image } from "./recording";

/** Width and height of a layer: larger images are made smaller, others larger. */
const SIZE = 1024;
/** So many layers of that size are taken, of more images each is smaller. */
const LARGE_LAYERS = 24;

/** Unpack the images; one that cannot be read is white. */
export async function loadImages(images: readonly Image[]): Promise<DataArrayTexture> {
  const halvings = Math.max(0, Math.ceil(Math.log2(images.length / LARGE_LAYERS) / 2));
  const size = images.length > 0 ? Math.max(SIZE >> halvings, 64) : 1;
  const data = new Uint8Array(4 * size * size * Math.max(images.length, 1)).fill(255);
  for (const [layer, image] of images.entries()) {
    const pixels = await unpack(image, size).catch(() => null);
    if (pixels !== null) data.set(pixels, 4 * size * size * layer);
  }
  const texture = new DataArrayTexture(data, size, size, Math.max(images.length, 1));
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.magFilter = LinearFilter;
  texture.anisotropy = 4;
  texture.generateMipmaps = true;
  texture.needsUpdate = true;
  return texture;
}

/** Pixels of an image, lowest row first. */
async function unpack(image: Image, size: number): Promise<Uint8ClampedArray> {
  const bytes = Uint8Array.from(atob(image.data), (character) => character.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes], { type: image.mime }), {
    colorSpaceConversion: "none",
    premultiplyAlpha: "none",
  });
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (context === null) throw new Error("no canvas");
  context.setTransform(1, 0, 0, -1, 0, size);
  context.drawImage(bitmap, 0, 0, size, size);
  bitmap.close();
  return context.getImageData(0, 0, size, size).data;
}
