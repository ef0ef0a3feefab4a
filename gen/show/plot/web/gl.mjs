// A few words over WebGL2: programs, buffers of instances, tables of colours.
function shader(gl, kind, text) {
  const made = gl.createShader(kind);
  gl.shaderSource(made, text); gl.compileShader(made);
  if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
  return made;
}
export function program(gl, [vertex, fragment]) {   // with the places of its uniforms by name
  const made = gl.createProgram(), places = {};
  gl.attachShader(made, shader(gl, gl.VERTEX_SHADER, vertex));
  gl.attachShader(made, shader(gl, gl.FRAGMENT_SHADER, fragment));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const many = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
  for (let k = 0; k < many; k++) {
    const { name } = gl.getActiveUniform(made, k);
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}

const SETTERS = {
  1: (gl, at, v) => gl.uniform1f(at, v[0]), 2: (gl, at, v) => gl.uniform2f(at, ...v), 3: (gl, at, v) => gl.uniform3f(at, ...v),
  4: (gl, at, v) => gl.uniform4f(at, ...v), 9: (gl, at, v) => gl.uniformMatrix3fv(at, false, v),
};
const WHOLE = new Set(["kind", "inked", "plane", "table", "pieces"]);
export function use(gl, { made, places }, values) { // numbers by name; those that the program has
  gl.useProgram(made);
  for (const [name, value] of Object.entries(values)) {
    if (!(name in places)) continue;
    if (WHOLE.has(name)) gl.uniform1i(places[name], value);
    else {
      const list = [value].flat(2);
      SETTERS[list.length](gl, places[name], list);
    }
  }
}

export function attribute(gl, where, data, size, { each = 1, normalized = false } = {}) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  pointed(gl, where, buffer, data.constructor, size, { each, normalized });
  return buffer;
}
export function pointed(gl, where, buffer, Kind, size, { each = 1, normalized = false } = {}) {    // an attribute reads this buffer
  const kind = { Float32Array: gl.FLOAT, Int16Array: gl.SHORT, Uint8Array: gl.UNSIGNED_BYTE }[Kind.name];
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(where);
  gl.vertexAttribPointer(where, size, kind, normalized, size * Kind.BYTES_PER_ELEMENT, 0);
  gl.vertexAttribDivisor(where, each);
}
export function refill(gl, buffer, data) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  if (buffer.bytes === data.byteLength) gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
  else gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  buffer.bytes = data.byteLength;
}
export function table(gl, colors) {         // a row of colours, read between its entries
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, colors.length, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(colors.flat()));
  for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
                              [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) {
    gl.texParameteri(gl.TEXTURE_2D, key, value);
  }
  return made;
}
