// The map in 3-D. The page has the scene as JSON (#scene), the points as bytes in base64 (#points) and the place for
// the view (#view3d); three.js and its OrbitControls were loaded before. Draws only when something changed.
(function () {
  'use strict';
  var place = document.getElementById('view3d');
  if (place) start();
  // Everything is on paper, also what is folded away on the screen.
  window.addEventListener('beforeprint', function () {
    document.querySelectorAll('details').forEach(function (part) { part.open = true; });
  });

  function start() {
    var scene = JSON.parse(document.getElementById('scene').textContent);
    var renderer;
    try {
      renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    } catch (error) {
      return;  // What stands in the place says that there is no 3-D here.
    }
    place.querySelector('.no3d').remove();
    place.appendChild(renderer.domElement);
    renderer.setClearColor(0x10141a);

    var world = new THREE.Scene();
    var middle = new THREE.Vector3(scene.center[0], scene.center[1], scene.center[2]);
    var camera = new THREE.PerspectiveCamera(50, 1, 0.01, 20 * scene.half);
    camera.up.set(0, 0, 1);
    var controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.enableKeys = false;
    controls.screenSpacePanning = true;
    controls.enableZoom = false;  // A wheel over the view scrolls the page until the view was clicked.
    renderer.domElement.addEventListener('mousedown', function () { controls.enableZoom = true; }, true);
    renderer.domElement.addEventListener('touchstart', function () { controls.enableZoom = true; }, true);
    renderer.domElement.addEventListener('mouseleave', function () { controls.enableZoom = false; });

    var cloud = makeCloud(scene);
    world.add(cloud);
    var sensors = new THREE.Group();
    var reach = Math.max(0.6, Math.min(3, 0.12 * scene.half));
    scene.sensors.forEach(function (sensor) { sensors.add(makeSensor(sensor, reach)); });
    sensors.add(makeWay(scene.stops));
    world.add(sensors);

    var waiting = false;
    function draw() {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(function () {
        waiting = false;
        nameSensors();
        renderer.render(world, camera);
      });
    }
    // From afar the names would hide the rig.
    function nameSensors() {
      var near = camera.position.length() < 6 * reach;
      sensors.children.forEach(function (sensor) {
        sensor.children.forEach(function (part) { if (part.isSprite) part.visible = near; });
      });
    }
    function look(from, at) {
      // Where the view is taller than wide, as on a phone, the scene fits from farther away.
      camera.position.copy(from).multiplyScalar(Math.max(1, 1.5 / camera.aspect)).add(at);
      controls.target.copy(at);
      controls.update();
      draw();
    }
    function resize() {
      var width = place.clientWidth, height = place.clientHeight;
      if (!width || !height) return;
      renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
      renderer.setSize(width, height);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      nameSensors();
      renderer.render(world, camera);
    }
    controls.addEventListener('change', draw);
    window.addEventListener('resize', resize);

    var half = scene.half, rig = new THREE.Vector3(0, 0, 0);
    var aslant = new THREE.Vector3(-0.75 * half, -0.9 * half, 0.85 * half);
    var buttons = document.querySelector('.buttons');
    function button(text, action, pressed) {
      var one = document.createElement('button');
      one.type = 'button';
      one.textContent = text;
      if (pressed !== undefined) one.setAttribute('aria-pressed', String(pressed));
      one.addEventListener('click', function () { action(one); });
      buttons.appendChild(one);
    }
    button('aslant', function () { look(aslant, middle); });
    button('from above', function () { look(new THREE.Vector3(0, -0.001 * half, 2.1 * half), middle); });
    button('from the side', function () { look(new THREE.Vector3(0, -2.1 * half, 0.02 * half), middle); });
    button('the rig', function () { look(new THREE.Vector3(-1.1 * reach, -1.4 * reach, 0.9 * reach), rig); });
    button('colour by sensor', function (one) {
      var on = one.getAttribute('aria-pressed') !== 'true';
      one.setAttribute('aria-pressed', String(on));
      cloud.geometry.setAttribute('color', on ? cloud.userData.bySensor : cloud.userData.own);
      draw();
    }, false);
    button('sensors', function (one) {
      sensors.visible = !sensors.visible;
      one.setAttribute('aria-pressed', String(sensors.visible));
      draw();
    }, true);
    resize();
    look(aslant, middle);
  }

  function makeCloud(scene) {
    var text = atob(document.getElementById('points').textContent);
    var count = text.length / 10, step = scene.half / 32767;
    var places = new Float32Array(3 * count), own = new Uint8Array(3 * count), bySensor = new Uint8Array(3 * count);
    for (var i = 0; i < count; ++i) {
      var at = 10 * i, colour = scene.palette[text.charCodeAt(at + 9) % scene.palette.length];
      for (var k = 0; k < 3; ++k) {
        var value = text.charCodeAt(at + 2 * k) | (text.charCodeAt(at + 2 * k + 1) << 8);
        places[3 * i + k] = scene.center[k] + step * (value > 32767 ? value - 65536 : value);
        // Dark surfaces are to be seen on the dark ground.
        own[3 * i + k] = 60 + 195 * Math.sqrt(text.charCodeAt(at + 6 + k) / 255);
        bySensor[3 * i + k] = colour[k];
      }
    }
    var geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
    var cloud = new THREE.Points(geometry, new THREE.PointsMaterial({
      size: 1.6 * Math.min(window.devicePixelRatio || 1, 2), sizeAttenuation: false, vertexColors: THREE.VertexColors
    }));
    cloud.userData.own = new THREE.BufferAttribute(own, 3, true);
    cloud.userData.bySensor = new THREE.BufferAttribute(bySensor, 3, true);
    geometry.setAttribute('color', cloud.userData.own);
    return cloud;
  }

  // Axes (x red, y green, z blue), the border of what it sees, its name.
  function makeSensor(sensor, reach) {
    var group = new THREE.Group();
    group.matrixAutoUpdate = false;
    group.matrix.fromArray(sensor.T);
    group.add(new THREE.AxesHelper(0.12 * reach));
    var corners = [];
    sensor.view.forEach(function (ray, k) {
      var next = sensor.view[(k + 1) % sensor.view.length];
      corners.push(reach * ray[0], reach * ray[1], reach * ray[2], reach * next[0], reach * next[1], reach * next[2]);
      if (k % 8 === 0) corners.push(0, 0, 0, reach * ray[0], reach * ray[1], reach * ray[2]);
    });
    var geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(corners), 3));
    var rgb = 'rgb(' + sensor.colour.join(',') + ')';
    group.add(new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: rgb })));
    var label = makeLabel(sensor.name, rgb);
    if (sensor.view.length) {
      var mean = sensor.view.reduce(function (sum, ray) { return sum.map(function (s, k) { return s + ray[k]; }); });
      label.position.fromArray(mean).normalize().multiplyScalar(reach);
    }
    group.add(label);
    return group;
  }

  function makeLabel(text, rgb) {
    var canvas = document.createElement('canvas'), pen = canvas.getContext('2d'), font = '600 40px sans-serif';
    pen.font = font;
    canvas.width = Math.ceil(pen.measureText(text).width) + 16;
    canvas.height = 56;
    pen.font = font;
    pen.fillStyle = 'rgba(16, 20, 26, 0.75)';
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = rgb;
    pen.fillText(text, 8, 42);
    var texture = new THREE.CanvasTexture(canvas);
    texture.minFilter = THREE.LinearFilter;
    var label = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, sizeAttenuation: false, depthTest: false }));
    label.scale.set(0.035 * canvas.width / canvas.height, 0.035, 1);
    return label;
  }

  function makeWay(stops) {
    var places = [];
    stops.forEach(function (stop) { places.push(stop[0], stop[1], stop[2]); });
    var geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(places), 3));
    return new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: 0xffffff }));
  }
})();
