"use strict";
// The mechanism in motion. Reads the JSON in #scene; makes window.mpcgear for scripts and tests.
(() => {
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const $ = (id) => document.getElementById(id);
  const first = scene.phi_deg[0], last = scene.phi_deg[scene.phi_deg.length - 1];
  const state = { phi: first, turns: 0, playing: false, speed: 1, dirty: true };
  const SECONDS_PER_TURN = 8;

  // Pose of the follower between the rows of the table.
  const pose = (i) => ({
    t: new THREE.Vector3(...scene.poses[i].slice(0, 3)),
    q: new THREE.Quaternion(scene.poses[i][4], scene.poses[i][5], scene.poses[i][6], scene.poses[i][3]),
  });
  function row(phi) {
    const x = scene.phi_deg;
    let low = 0, high = x.length - 1;
    while (high - low > 1) { const mid = (low + high) >> 1; if (x[mid] > phi) high = mid; else low = mid; }
    const f = high > low ? Math.min(Math.max((phi - x[low]) / (x[high] - x[low]), 0), 1) : 0;
    return { low, high, f };
  }
  function followerPose(phi) {
    const { low, high, f } = row(phi), a = pose(low), b = pose(high);
    return new THREE.Matrix4().compose(a.t.lerp(b.t, f), a.q.slerp(b.q, f), new THREE.Vector3(1, 1, 1));
  }
  const follower0 = followerPose(first).invert();
  function motionOf(moves, phi) {
    const m = new THREE.Matrix4();
    if (moves === "driver") {
      const L = scene.center_distance, turn = THREE.MathUtils.degToRad((phi - first + 360 * state.turns) * scene.driver_rate);
      m.makeTranslation(-L, 0, 0).multiply(new THREE.Matrix4().makeRotationZ(turn)).multiply(new THREE.Matrix4().makeTranslation(L, 0, 0));
    } else if (moves === "follower") {
      m.copy(followerPose(phi)).multiply(follower0);
    } else if (moves === "slider") {
      const { low, high, f } = row(phi);
      m.makeTranslation(0, 0, scene.lift[low] * (1 - f) + scene.lift[high] * f - scene.lift[0]);
    }
    return m;
  }

  // Curves first: they work without 3D graphics.
  for (const plot of scene.plots) charts.add($("plot-" + plot.id), plot, setPhi);

  let view = null;
  try { view = makeView(); document.querySelector(".stage").classList.add("live"); view.resize(); }
  catch (e) { $("no3d").hidden = false; $("no3d").title = String(e); }

  function setPhi(phi) {
    state.phi = Math.min(Math.max(phi, first), last);
    state.dirty = true;
    $("phi").value = state.phi;
    $("angle").value = state.phi.toFixed(1) + "°";
    $("phi").setAttribute("aria-valuetext", state.phi.toFixed(0) + " degrees");
    charts.show(state.phi);
  }

  function setPlaying(on) {
    state.playing = on;
    $("play").textContent = on ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", on);
  }

  let before = 0, direction = 1;
  function frame(time) {
    requestAnimationFrame(frame);
    const dt = Math.min((time - before) / 1000, 0.1);
    before = time;
    if (state.playing) {
      let phi = state.phi + direction * dt * state.speed * 360 / SECONDS_PER_TURN;
      if (scene.whole_turn) { if (phi > last) { phi -= last - first; state.turns += 1; } }
      else if (phi > last || phi < first) { direction = -direction; phi = Math.min(Math.max(phi, first), last); }
      setPhi(phi);
    }
    if (view) view.draw();
  }

  function makeView() {
    const canvas = $("canvas");
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.localClippingEnabled = true;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const world = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(28, 1, 1, 5000);
    camera.up.set(0, 0, 1);
    const light = new THREE.DirectionalLight(0xffffff, 2.1);
    camera.add(light);
    light.position.set(-0.5, 0.8, 1);
    world.add(camera, new THREE.HemisphereLight(0xffffff, 0x8a95a3, 1.5));
    const plane = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 0);
    const bounds = new THREE.Box3();

    const parts = scene.parts.map((part) => {
      const geometry = decode(part.mesh);
      geometry.computeBoundingBox();
      bounds.union(geometry.boundingBox);
      const front = new THREE.MeshStandardMaterial({ color: part.color, roughness: 0.62, metalness: 0.05, side: THREE.FrontSide });
      // Seen through a cut, the inside is filled with an even tone.
      const back = new THREE.MeshBasicMaterial({ color: new THREE.Color(part.color).multiplyScalar(0.72), side: THREE.BackSide });
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      const edges = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 40), new THREE.LineBasicMaterial({ color: 0x1c2530, transparent: true, opacity: 0.35 }));
      group.add(new THREE.Mesh(geometry, front), new THREE.Mesh(geometry, back), edges);
      world.add(group);
      return { ...part, group, front, back, edges };
    });
    const size = bounds.getSize(new THREE.Vector3()).length() || 100;
    const centre = bounds.getCenter(new THREE.Vector3());
    const away = { driver: [-0.3, 0, 0.12], follower: [0.1, 0, 0.5], slider: [0.32, 0, 0.12], support: [0, 0, 0] };

    // Contacts: a ball where teeth touch and an arrow the way the driver pushes; never hidden.
    const marks = new THREE.Group();
    world.add(marks);
    const arrows = scene.contacts.map((track, k) => {
      const series = (scene.plots.find((p) => p.id === "force") || { series: [] }).series[k];
      const color = series ? series.color : ["#d1495b", "#1b7f79", "#6a4c93", "#b7791f", "#2b6cb0", "#718355", "#c05299", "#4a5568"][k % 8];
      const material = new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true });
      const arrow = new THREE.Group();
      const r = size / 150;
      const ball = new THREE.Mesh(new THREE.SphereGeometry(1.5 * r, 20, 14), material);
      const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.5 * r, 0.5 * r, 9 * r, 12).translate(0, 4.5 * r, 0), material);
      const head = new THREE.Mesh(new THREE.ConeGeometry(1.4 * r, 4 * r, 16).translate(0, 11 * r, 0), material);
      arrow.add(ball, shaft, head);
      arrow.traverse((o) => { o.renderOrder = 10; });
      marks.add(arrow);
      return arrow;
    });

    const point = new THREE.Vector3(...scene.end_effector);
    const onPath = (phi) => point.clone().applyMatrix4(followerPose(phi));
    const path = new THREE.Group();
    const line = new THREE.BufferGeometry().setFromPoints(scene.phi_deg.map(onPath));
    path.add(new THREE.Line(line, new THREE.LineBasicMaterial({ color: 0xd1495b })));
    const tip = new THREE.Mesh(new THREE.SphereGeometry(size / 130, 20, 14), new THREE.MeshBasicMaterial({ color: 0xd1495b }));
    const stick = new THREE.Line(new THREE.BufferGeometry().setFromPoints([point, point]), new THREE.LineBasicMaterial({ color: 0x8a95a3 }));
    path.add(tip, stick);
    world.add(path);
    const seen = bounds.clone().union(new THREE.Box3().setFromObject(path));

    const controls = new THREE.OrbitControls(camera, canvas);
    controls.enableDamping = false;
    controls.addEventListener("change", () => { state.dirty = true; });
    let apartSeen = 0;
    function home() {
      // As near as all corners of the box allow.
      const middle = seen.getCenter(new THREE.Vector3()), towards = new THREE.Vector3(0.35, -1, 0.42).normalize();
      const right = new THREE.Vector3().crossVectors(camera.up, towards).normalize(), up = new THREE.Vector3().crossVectors(towards, right);
      const slopeY = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)) * 0.94, slopeX = slopeY * camera.aspect;
      let distance = 0;
      for (let i = 0; i < 8; i++) {
        const arm = new THREE.Vector3(i & 1 ? seen.max.x : seen.min.x, i & 2 ? seen.max.y : seen.min.y, i & 4 ? seen.max.z : seen.min.z).sub(middle);
        distance = Math.max(distance, arm.dot(towards) + Math.max(Math.abs(arm.dot(right)) / slopeX, Math.abs(arm.dot(up)) / slopeY));
      }
      camera.position.copy(middle).addScaledVector(towards, distance);
      camera.near = distance / 50; camera.far = distance * 20; camera.updateProjectionMatrix();
      controls.target.copy(middle);
      controls.update();
      apartSeen = 0;
    }
    // Pulling apart steps back, so that everything stays in view.
    function stepBack(apart) {
      const arm = camera.position.clone().sub(controls.target).multiplyScalar((1 + 0.75 * apart) / (1 + 0.75 * apartSeen));
      camera.position.copy(controls.target).add(arm);
      controls.update();
      apartSeen = apart;
    }

    function decode(mesh) {
      const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
      const grid = new Uint16Array(bytes(mesh.positions)), positions = new Float32Array(grid.length);
      for (let i = 0; i < grid.length; i++) positions[i] = mesh.origin[i % 3] + mesh.step[i % 3] * grid[i];
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
      geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(mesh.triangles)), 1));
      return THREE.toCreasedNormals(geometry, 0.6);
    }

    function draw() {
      if (!state.dirty) return;
      state.dirty = false;
      const apart = Number($("explode").value);
      if (apart !== apartSeen) stepBack(apart);
      for (const part of parts) {
        const shift = away[part.moves].map((a) => a * apart * size);
        part.group.matrix.makeTranslation(...shift).multiply(motionOf(part.moves, state.phi));
        part.group.matrixWorldNeedsUpdate = true;
        part.group.visible = part.box.checked;
        const glass = part.moves === "support" && $("glass").checked;
        for (const m of [part.front, part.back]) {
          if (m.transparent !== glass) { m.transparent = glass; m.depthWrite = !glass; m.needsUpdate = true; }
          m.opacity = glass ? (m === part.back ? 0.08 : 0.3) : 1;
        }
        part.edges.material.opacity = glass ? 0.22 : 0.35;
        part.edges.visible = !$("axis").value; // lines of the far side would cross the cut
      }
      const { low, high, f } = row(state.phi), near = f < 0.5 ? low : high;
      marks.visible = $("contacts").checked && apart === 0;
      arrows.forEach((arrow, k) => {
        const c = scene.contacts[k][near];
        arrow.position.set(c[0], c[1], c[2]);
        arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(c[3], c[4], c[5]));
      });
      path.visible = $("path").checked && apart === 0;
      tip.position.copy(onPath(state.phi));
      const foot = new THREE.Vector3().applyMatrix4(followerPose(state.phi));
      stick.geometry.setFromPoints([foot, tip.position]);
      const axis = $("axis").value;
      if (axis) {
        plane.normal.set(axis === "x" ? -1 : 0, axis === "y" ? 1 : 0, axis === "z" ? -1 : 0);
        const at = bounds.min[axis] + (bounds.max[axis] - bounds.min[axis]) * Number($("cut").value);
        plane.constant = axis === "y" ? -at : at;
      }
      for (const part of parts) for (const m of [part.front, part.back, part.edges.material]) m.clippingPlanes = axis ? [plane] : null;
      renderer.render(world, camera);
    }

    function resize() {
      const box = canvas.parentElement;
      renderer.setSize(box.clientWidth, box.clientHeight, false);
      camera.aspect = box.clientWidth / box.clientHeight;
      camera.updateProjectionMatrix();
      state.dirty = true;
    }

    for (const part of parts) {
      const label = document.createElement("label"), box = document.createElement("input"), color = document.createElement("input");
      box.type = "checkbox"; box.checked = true; part.box = box;
      color.type = "color"; color.value = part.color; color.setAttribute("aria-label", "Colour of " + part.label);
      color.addEventListener("input", () => { part.front.color.set(color.value); part.back.color.set(color.value).multiplyScalar(0.72); state.dirty = true; });
      box.addEventListener("input", () => { state.dirty = true; });
      label.append(box, part.label, color);
      $("parts").append(label);
    }
    resize();
    home();
    new ResizeObserver(resize).observe(canvas.parentElement);

    canvas.addEventListener("keydown", (e) => {
      const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
      const arm = camera.position.clone().sub(controls.target);
      if (steps) {
        const side = new THREE.Vector3().crossVectors(camera.up, arm).normalize();
        arm.applyAxisAngle(camera.up, steps[0] * 0.08).applyAxisAngle(side, -steps[1] * 0.08);
      } else if (e.key === "+" || e.key === "=") arm.multiplyScalar(0.92);
      else if (e.key === "-") arm.multiplyScalar(1.08);
      else return;
      camera.position.copy(controls.target).add(arm);
      controls.update();
      state.dirty = true;
      e.preventDefault();
    });
    return { draw, resize, home, parts, camera, arrows };
  }

  $("phi").min = first; $("phi").max = last;
  $("phi").addEventListener("input", () => { setPlaying(false); setPhi(Number($("phi").value)); });
  $("play").addEventListener("click", () => setPlaying(!state.playing));
  $("speed").addEventListener("input", () => { state.speed = Number($("speed").value); });
  $("axis").addEventListener("input", () => { $("cut").disabled = !$("axis").value; });
  for (const id of ["contacts", "path", "glass", "explode", "axis", "cut"]) $(id).addEventListener("input", () => { state.dirty = true; });
  $("reset").addEventListener("click", reset);
  function reset() {
    $("explode").value = 0; $("axis").value = ""; $("cut").disabled = true; state.dirty = true;
    if (view) view.home();
  }
  const flip = (id) => { $(id).checked = !$(id).checked; state.dirty = true; };
  document.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|BUTTON|SUMMARY|A)$/.test(e.target.tagName)) return;
    const act = { " ": () => setPlaying(!state.playing), ",": () => setPhi(state.phi - 1), ".": () => setPhi(state.phi + 1), r: reset, c: () => flip("contacts"), f: () => flip("glass") }[e.key.toLowerCase()];
    if (act) { act(); e.preventDefault(); }
  });
  if (matchMedia("(max-width: 900px)").matches) document.querySelector(".tools").open = false;

  window.mpcgear = {
    setPhi, state, scene, view,
    /** Follower pose at the present φ, row by row, as the view applies it to a body given at φ = 0. */
    followerMatrix: () => motionOf("follower", state.phi).transpose().toArray(),
  };
  setPhi(first);
  requestAnimationFrame(frame);
})();
