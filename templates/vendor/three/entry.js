// What the report uses of three.js; README.md says how the bundle is made from it.
export {
  BackSide, Box3, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
  EdgesGeometry, FrontSide, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, MathUtils, Matrix4,
  Mesh, MeshBasicMaterial, MeshStandardMaterial, PerspectiveCamera, Plane, Quaternion, Scene, Sphere,
  SphereGeometry, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
