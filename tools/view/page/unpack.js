// Reads what tools/view/pack.cc writes: base64 of a zlib stream of a length, a JSON document and arrays of numbers.

const kTypes = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function fromBase64(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

// An array's bytes stand in planes; whole numbers may be differences, see Pack::add().
function readArray(bytes, { type, at, count, strides = [] }) {
  const array = new kTypes[type](count);
  const width = array.BYTES_PER_ELEMENT;
  const raw = new Uint8Array(array.buffer);
  for (let plane = 0; plane < width; ++plane) {
    const from = at + plane * count;
    for (let i = 0; i < count; ++i) raw[i * width + plane] = bytes[from + i];
  }
  if (strides.length === 0) return array;
  for (let i = 0; i < count; ++i) array[i] = (array[i] >>> 1) ^ -(array[i] & 1);
  for (let s = strides.length - 1; s >= 0; --s) {
    for (let i = strides[s]; i < count; ++i) array[i] += array[i - strides[s]];
  }
  return array;
}

// The document, and a function that reads the array that a place of it refers to.
export async function unpack(text) {
  const bytes = await inflate(fromBase64(text));
  const size = new DataView(bytes.buffer).getUint32(0, true);
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
  const arrays = bytes.subarray(4 + size);
  return { document, array: (reference) => readArray(arrays, reference) };
}
