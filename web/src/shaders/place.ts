// Vertex shaders: corners of bodies, whose poses and looks are read from textures.

/** Columns of the textures that hold something for each body or material. */
export const TABLE_WIDTH = 1024;

/** Entries of tables, and rotations by quaternions. */
export const TABLES = /* glsl */ `
vec4 entry(sampler2D table, uint index) {
  return texelFetch(table, ivec2(index % ${TABLE_WIDTH}u, index / ${TABLE_WIDTH}u), 0);
}

vec3 turned(vec4 q, vec3 v) {
  return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}
`;

const PLACE = /* glsl */ `
precision highp float;
precision highp int;
in vec3 position;
in vec4 normal;
in uvec2 ids;
#ifdef SKINNED
in vec2 place;
in vec4 cornerColour;
#endif
uniform sampler2D poses;
${TABLES}

/**
 * Where the corner is, relative to the stage's origin; outside of everything for a body that is not
 * shown.
 */
vec4 placed(mat4 matrix, out vec3 world) {
  vec4 pose = entry(poses, 2u * ids.x);
  world = pose.xyz + turned(entry(poses, 2u * ids.x + 1u), position);
  return pose.w > 0.5 ? matrix * vec4(world, 1.0) : vec4(0.0, 0.0, 2.0, 1.0);
}
`;

/** For what a lamp sees; what lies before its near plane is pressed onto it. */
export const LAMP_VERTEX = /* glsl */ `
${PLACE}
uniform mat4 lampMatrix;

void main() {
  vec3 world;
  gl_Position = placed(lampMatrix, world);
  gl_Position.z = max(gl_Position.z, -gl_Position.w);
}
`;

export const LAMP_FRAGMENT = /* glsl */ `
precision highp float;
out vec4 nothing;
void main() { nothing = vec4(1.0); }
`;

/** For the normals that the ambient light is looked for with. */
export const NORMAL_VERTEX = /* glsl */ `
${PLACE}
uniform mat4 viewProjection;
uniform mat4 view;
out vec3 normalView;

void main() {
  vec3 world;
  gl_Position = placed(viewProjection, world);
  normalView = mat3(view) * turned(entry(poses, 2u * ids.x + 1u), normal.xyz);
}
`;

export const NORMAL_FRAGMENT = /* glsl */ `
precision highp float;
in vec3 normalView;
out vec4 encoded;
void main() {
  vec3 n = normalize(normalView) * (gl_FrontFacing ? 1.0 : -1.0);
  encoded = vec4(0.5 + 0.5 * n, 1.0);
}
`;

/**
 * For what the eye sees: what a body looks like, fragments read themselves, as they are fewer where
 * it is slow.
 */
export const SURFACE_VERTEX = /* glsl */ `
${PLACE}
uniform mat4 viewProjection;
out vec3 world;
out vec3 normalWorld;
out vec3 pointBody;
flat out uvec2 bodyAndMaterial;
#ifdef SKINNED
out vec2 imagePlace;
out vec4 corner;
#endif

void main() {
  gl_Position = placed(viewProjection, world);
  normalWorld = turned(entry(poses, 2u * ids.x + 1u), normal.xyz);
  pointBody = position;
  bodyAndMaterial = ids;
#ifdef SKINNED
  imagePlace = place;
  corner = cornerColour;
#endif
}
`;
