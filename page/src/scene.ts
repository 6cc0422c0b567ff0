// This file draws the scene in three dimensions: coloured polygons, the outline of the selection, and picking.
import {
  BackSide, BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, IncrementStencilOp, LessEqualStencilFunc, LineSegments, Matrix4, Mesh, PerspectiveCamera, Ray, Raycaster, Scene as World, ShaderMaterial, Sphere, Spherical, Vector2,
  Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { MeshBVH } from 'three-mesh-bvh';
import { type Colour, palette } from './colours';
import type { Contents } from './contents';
import { Pace } from './pace';

export type Backs = 'dotted' | 'hatched' | 'hidden' | 'solid';
const MOST_EDGES = 40000; // with more edges they would hide the colours and take long, so none are drawn
const STILL_MS = 180; // time after the last movement until the scene is drawn sharp
const MOVING_SHARE = 0.5; // share of a large scene's pixels, across and down, while it moves

// The shader darkens faces a little where they are seen at an angle. Backs are dotted or hatched, and seen
// through.
const FACE_VERTEX = `
in vec3 tint;
uniform mat4 to_screen;
out vec3 colour;
out vec3 place;
void main() {
  colour = tint;
  place = position - cameraPosition;
  gl_Position = to_screen * vec4(position, 1.0);
}`;
const FACE_FRAGMENT = `
in vec3 colour;
in vec3 place;
uniform vec3 back;
uniform float spacing;
uniform bool is_solid;
uniform bool is_dotted;
out vec4 result;
void main() {
  float facing = abs(dot(normalize(cross(dFdx(place), dFdy(place))), normalize(place)));
  float shade = 0.82 + 0.18 * facing;
  if (gl_FrontFacing) {
    result = vec4(colour * shade, 1.0);
    return;
  }
  vec2 dot_place = mod(gl_FragCoord.xy, 0.75 * spacing);
  bool is_line = is_dotted ? max(dot_place.x, dot_place.y) < 0.13 * spacing : mod(gl_FragCoord.x + gl_FragCoord.y, spacing) < 0.16 * spacing;
  if (!is_line && !is_solid) discard;
  result = vec4(is_line ? back : mix(back, vec3(0.5), 0.55) * shade, 1.0);
}`;
const WRONG_VERTEX = `
uniform mat4 to_screen;
void main() { gl_Position = to_screen * vec4(position, 1.0); }`;
const WRONG_FRAGMENT = `
uniform vec3 back;
out vec4 result;
void main() { result = vec4(back, 1.0); }`;
// The shader draws edges of fronts only.
const EDGE_VERTEX = `
out float front;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  front = -dot(normalMatrix * normal, seen.xyz);
  gl_Position = projectionMatrix * seen;
}`;
const EDGE_FRAGMENT = `
in float front;
uniform vec3 ink;
out vec4 result;
void main() {
  if (front <= 0.0) discard;
  result = vec4(ink, 0.22);
}`;

interface Shapes {
  corners: Float32Array; // three coordinates each
  firstCorner: Int32Array; // by polygon, and the end of the last
  triangles: Uint32Array; // three corners each
  polygonOfTriangle: Int32Array;
}

async function loadShapes(contents: Contents): Promise<Shapes> {
  const [x, y, z, counts] = await Promise.all([contents.array('x'), contents.array('y'), contents.array('z'), contents.array('corner_count')]);
  const firstCorner = new Int32Array(counts.length + 1);
  for (let k = 0; k < counts.length; ++k) firstCorner[k + 1] = firstCorner[k] + counts[k];
  const corners = new Float32Array(3 * x.length);
  for (let c = 0; c < x.length; ++c) corners.set([x[c], y[c], z[c]], 3 * c);
  const triangleCount = x.length - 2 * counts.length;
  const triangles = new Uint32Array(3 * triangleCount), polygonOfTriangle = new Int32Array(triangleCount);
  for (let k = 0, triangle = 0; k < counts.length; ++k)
    for (let c = 1; c + 1 < counts[k]; ++c, ++triangle) {
      polygonOfTriangle[triangle] = k;
      triangles.set([firstCorner[k], firstCorner[k] + c, firstCorner[k] + c + 1], 3 * triangle);
    }
  return { corners, firstCorner, triangles, polygonOfTriangle };
}

export class Scene {
  private readonly renderer: WebGLRenderer;
  private readonly world = new World();
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 100);
  private controls: OrbitControls;
  private readonly geometry = new BufferGeometry();
  private readonly tints: BufferAttribute;
  private readonly toScreen = new Matrix4();
  private readonly face: ShaderMaterial;
  private readonly edge: ShaderMaterial;
  private readonly wrongFaces: Mesh[] = [];
  private readonly outlines: LineSegments2[] = [];
  private readonly sphere: Sphere;
  private tree?: MeshBVH;
  private isAsked = false;
  private readonly isLarge: boolean;
  private isMoving = false;
  private isPlacing = false; // whether the code, not the user, is moving the camera
  private stillTimer = 0;
  private readonly pace: Pace;
  frames = 0;
  onHover: (polygon: number | undefined, x: number, y: number) => void = () => {};
  onPick: (polygon: number | undefined) => void = () => {};

  static async make(contents: Contents, canvas: HTMLCanvasElement): Promise<Scene> {
    return new Scene(await loadShapes(contents), canvas);
  }

  private constructor(private readonly shapes: Shapes, private readonly canvas: HTMLCanvasElement) {
    this.isLarge = shapes.corners.length / 3 > MOST_EDGES;
    this.pace = new Pace(this.isLarge ? MOVING_SHARE : 1);
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.isLarge, alpha: true, stencil: true });
    this.tints = new BufferAttribute(new Uint8Array(shapes.corners.length), 3, true);
    this.geometry.setAttribute('position', new BufferAttribute(shapes.corners, 3));
    this.geometry.setAttribute('tint', this.tints);
    this.geometry.setIndex(new BufferAttribute(shapes.triangles, 1));
    this.geometry.computeBoundingSphere();
    this.sphere = this.geometry.boundingSphere as Sphere;
    if (!(this.sphere.radius > 0)) this.sphere.radius = 1;
    const glsl3 = { glslVersion: '300 es' as const };
    this.face = new ShaderMaterial({
      ...glsl3, vertexShader: FACE_VERTEX, fragmentShader: FACE_FRAGMENT, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      uniforms: { to_screen: { value: this.toScreen }, back: { value: sRgb(palette.back) }, spacing: { value: 13 }, is_solid: { value: false }, is_dotted: { value: false } },
    });
    this.edge = new ShaderMaterial({ ...glsl3, vertexShader: EDGE_VERTEX, fragmentShader: EDGE_FRAGMENT, transparent: true, depthWrite: false, uniforms: { ink: { value: sRgb(palette.light.ink) } } });
    const mesh = new Mesh(this.geometry, this.face);
    mesh.onBeforeRender = () => this.toScreen.multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    this.world.add(mesh);
    this.addWrongFaces(glsl3);
    this.addEdges();
    for (const isFront of [false, true]) {
      const material = new LineMaterial({ color: palette.selected, linewidth: isFront ? 3.5 : 2, transparent: true, opacity: isFront ? 1 : 0.45, depthTest: isFront });
      const outline = new LineSegments2(new LineSegmentsGeometry(), material);
      outline.visible = false;
      outline.frustumCulled = false;
      this.outlines.push(outline);
      this.world.add(outline);
    }
    this.camera.up.set(0, 0, 1);
    this.controls = this.makeControls();
    this.resize();
    this.showAll();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as Element);
  }

  // Colours all polygons.    In: colourOf: returns the colour of a polygon, given its index
  paint(colourOf: (polygon: number) => Colour): void {
    const bytes = this.tints.array, { firstCorner } = this.shapes;
    for (let polygon = 0; polygon + 1 < firstCorner.length; ++polygon) {
      const [red, green, blue] = colourOf(polygon);
      for (let at = 3 * firstCorner[polygon]; at < 3 * firstCorner[polygon + 1]; at += 3) [bytes[at], bytes[at + 1], bytes[at + 2]] = [red, green, blue];
    }
    this.tints.needsUpdate = true;
    this.draw();
  }

  // Outlines several polygons as one: edges that two of them share are left out.
  outline(polygons: number[]): void {
    const { corners, firstCorner } = this.shapes;
    const edges = new Map<string, number[] | undefined>();
    const key = (c: number) => corners.subarray(3 * c, 3 * c + 3).join();
    for (const polygon of polygons) {
      const first = firstCorner[polygon], end = firstCorner[polygon + 1];
      for (let c = first; c < end; ++c) {
        const next = c + 1 < end ? c + 1 : first;
        const name = [key(c), key(next)].sort().join(';');
        edges.set(name, edges.has(name) ? undefined : [...corners.subarray(3 * c, 3 * c + 3), ...corners.subarray(3 * next, 3 * next + 3)]);
      }
    }
    const points = [...edges.values()].filter((edge) => edge !== undefined).flat();
    for (const outline of this.outlines) {
      outline.visible = points.length > 0;
      if (points.length === 0) continue;
      outline.geometry.dispose();
      outline.geometry = new LineSegmentsGeometry().setPositions(points);
    }
    this.draw();
  }

  setBacks(backs: Backs): void {
    this.face.side = backs === 'hidden' ? FrontSide : DoubleSide;
    this.face.uniforms.is_solid.value = backs === 'solid';
    this.face.uniforms.is_dotted.value = backs === 'dotted';
    this.face.needsUpdate = true;
    for (const mesh of this.wrongFaces) mesh.visible = backs === 'hatched';
    this.draw();
  }

  setInk(hex: string): void {
    this.edge.uniforms.ink.value = sRgb(hex);
    this.draw();
  }

  setUp(axis: 'x' | 'y' | 'z'): void {
    this.camera.up.set(Number(axis === 'x'), Number(axis === 'y'), Number(axis === 'z'));
    this.controls.dispose();
    this.controls = this.makeControls();
    this.showAll();
  }

  showAll(): void {
    const { up } = this.camera;
    const side = up.y ? new Vector3(0.62, 0.52, 0.9) : up.x ? new Vector3(0.52, 0.62, 0.9) : new Vector3(0.62, -0.9, 0.52);
    const { middle, distance } = this.placeToSeeAll(side.normalize());
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(side, distance);
    this.camera.near = this.sphere.radius / 500;
    this.camera.far = distance + 60 * this.sphere.radius;
    this.camera.updateProjectionMatrix();
    this.isPlacing = true;
    this.controls.update();
    this.isPlacing = false;
    this.draw();
  }

  // Returns where the camera must look, and from which distance, to see every corner with the scene in the middle.
  //   In: side: unit vector from the scene to the camera
  private placeToSeeAll(side: Vector3): { middle: Vector3; distance: number } {
    const right = this.camera.up.clone().cross(side).normalize(), over = side.clone().cross(right);
    const tall = 0.88 * Math.tan((this.camera.fov * Math.PI) / 360), wide = tall * this.camera.aspect;
    const { corners } = this.shapes, corner = new Vector3(), middle = this.sphere.center.clone();
    let distance = 0;
    for (let turn = 0; turn < 3; ++turn) {
      const far = [0, 0, 0, 0]; // distances from which the corners to the right, left, above and below are seen
      for (let at = 0; at < corners.length; at += 3) {
        corner.fromArray(corners, at).sub(middle);
        const near = corner.dot(side), x = corner.dot(right) / wide, y = corner.dot(over) / tall;
        [x, -x, y, -y].forEach((need, k) => (far[k] = Math.max(far[k], near + need)));
      }
      distance = Math.max(...far, 0.1 * this.sphere.radius);
      middle.addScaledVector(right, ((far[0] - far[1]) / 2) * wide).addScaledVector(over, ((far[2] - far[3]) / 2) * tall);
    }
    return { middle, distance: distance * 1.01 };
  }

  // Turns the camera by angles in radians, or zooms by a factor.
  turn(around: number, over: number, zoom = 1): void {
    const toUp = this.camera.up;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const turned = new Spherical();
    const toY = (v: Vector3) => (toUp.z ? v.set(v.x, v.z, -v.y) : toUp.x ? v.set(-v.y, v.x, v.z) : v);
    const back = (v: Vector3) => (toUp.z ? v.set(v.x, -v.z, v.y) : toUp.x ? v.set(v.y, -v.x, v.z) : v);
    turned.setFromVector3(toY(offset));
    turned.theta += around;
    turned.phi = Math.min(Math.PI - 0.01, Math.max(0.01, turned.phi + over));
    turned.radius *= zoom;
    this.camera.position.copy(this.controls.target).add(back(offset.setFromSpherical(turned)));
    this.controls.update();
    this.draw();
  }

  // Returns the polygon at a point of the window. Backs are passed over unless they are drawn solid.
  pick(x: number, y: number): number | undefined {
    this.tree ??= new MeshBVH(this.geometry, { indirect: true });
    const box = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), this.camera);
    const ray: Ray = caster.ray;
    const hit = this.tree.raycastFirst(ray, this.face.uniforms.is_solid.value ? DoubleSide : FrontSide);
    return hit?.faceIndex === undefined || hit.faceIndex === null ? undefined : this.shapes.polygonOfTriangle[hit.faceIndex];
  }

  draw(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame((time) => {
      this.isAsked = false;
      this.renderer.render(this.world, this.camera);
      ++this.frames;
      if (!this.isMoving) return;
      clearTimeout(this.stillTimer);
      this.stillTimer = window.setTimeout(() => this.setMoving(false), STILL_MS);
      if (this.pace.addFrame(time)) this.resize();
    });
  }

  // Draws a moving scene, more coarsely where its pace requires; once it stands still it is drawn sharp.
  private drawMoving(): void {
    if (!this.isMoving) this.setMoving(true);
    this.draw();
  }

  private setMoving(isMoving: boolean): void {
    this.isMoving = isMoving;
    if (isMoving) this.pace.begin();
    if (this.pace.share < 1) this.resize();
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.addEventListener('change', () => (this.isPlacing ? this.draw() : this.drawMoving()));
    return controls;
  }

  // Marks faces that look the wrong way. A line of sight that meets two backs before a front has met such a face. The
  // stencil counts backs before the nearest front, and where there are two they are drawn solid.
  private addWrongFaces(glsl3: { glslVersion: '300 es' }): void {
    const material = (rule: object) => new ShaderMaterial({
      ...glsl3, ...rule, vertexShader: WRONG_VERTEX, fragmentShader: WRONG_FRAGMENT, side: BackSide, depthWrite: false, stencilWrite: true,
      uniforms: { to_screen: { value: this.toScreen }, back: { value: sRgb(palette.back) } },
    });
    const rules = [{ colorWrite: false, stencilZPass: IncrementStencilOp }, { stencilRef: 2, stencilFunc: LessEqualStencilFunc }];
    rules.forEach((rule, k) => {
      const mesh = new Mesh(this.geometry, material(rule));
      mesh.renderOrder = k + 1;
      mesh.visible = false;
      this.wrongFaces.push(mesh);
      this.world.add(mesh);
    });
  }

  private addEdges(): void {
    const { corners, firstCorner } = this.shapes;
    const count = corners.length / 3;
    if (count > MOST_EDGES) return;
    const points = new Float32Array(6 * count), normals = new Float32Array(6 * count);
    const [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];
    for (let polygon = 0, at = 0; polygon + 1 < firstCorner.length; ++polygon) {
      const first = firstCorner[polygon], end = firstCorner[polygon + 1];
      a.fromArray(corners, 3 * first), b.fromArray(corners, 3 * first + 3), c.fromArray(corners, 3 * first + 6);
      const normal = b.sub(a).cross(c.sub(a)).normalize();
      for (let corner = first; corner < end; ++corner)
        for (const place of [corner, corner + 1 < end ? corner + 1 : first]) {
          points.set(corners.subarray(3 * place, 3 * place + 3), at);
          normals.set([normal.x, normal.y, normal.z], at);
          at += 3;
        }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points, 3));
    geometry.setAttribute('normal', new BufferAttribute(normals, 3));
    this.world.add(new LineSegments(geometry, this.edge));
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement as HTMLElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    const ratio = Math.min(2, window.devicePixelRatio) * (this.isMoving ? this.pace.share : 1);
    this.renderer.setDrawingBufferSize(clientWidth, clientHeight, ratio);
    this.face.uniforms.spacing.value = 13 * ratio;
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  private listen(): void {
    let pressed: { x: number; y: number } | undefined, moved: { x: number; y: number } | undefined, isWaiting = false;
    this.canvas.addEventListener('pointerdown', (event) => (pressed = { x: event.clientX, y: event.clientY }));
    this.canvas.addEventListener('pointerup', (event) => {
      if (pressed && event.button === 0 && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 5) this.onPick(this.pick(event.clientX, event.clientY));
      pressed = undefined;
    });
    this.canvas.addEventListener('pointermove', (event) => {
      moved = { x: event.clientX, y: event.clientY };
      if (isWaiting || event.buttons !== 0) return;
      isWaiting = true;
      requestAnimationFrame(() => {
        isWaiting = false;
        if (moved) this.onHover(this.pick(moved.x, moved.y), moved.x, moved.y);
      });
    });
    this.canvas.addEventListener('pointerleave', () => {
      moved = undefined;
      this.onHover(undefined, 0, 0);
    });
    this.canvas.addEventListener('keydown', (event) => {
      const step = 0.12;
      const turns: Record<string, [number, number, number?]> = {
        ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step], '+': [0, 0, 0.88], '=': [0, 0, 0.88], '-': [0, 0, 1 / 0.88],
      };
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === 'Home') this.showAll();
      else if (turns[event.key]) this.turn(...turns[event.key]);
      else return;
      event.preventDefault();
    });
  }
}

// Returns a colour that goes to the screen unchanged.
function sRgb(hex: string): Color {
  const colour = new Color();
  colour.setRGB(parseInt(hex.slice(1, 3), 16) / 255, parseInt(hex.slice(3, 5), 16) / 255, parseInt(hex.slice(5, 7), 16) / 255, 'srgb-linear');
  return colour;
}
