// Reads an MCAP file with Foxglove's own packages, and prints what read_mcap.py prints: a JSON object for each message,
// in the order of the file.
//
//   NODE_PATH=build/foxglove/node_modules node read_mcap.js FILE
//
// It reads the file twice, from its begin and by the index at its end, and fails if the two differ, if a checksum is
// wrong, or if a definition does not cover its message.
"use strict";
const assert = require("node:assert");
const fs = require("node:fs");
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const lz4 = require("@foxglove/wasm-lz4");
const zstd = require("@foxglove/wasm-zstd");

/** JSON as Python writes it: large integers are numbers, and arrays of numbers are lists. */
function json(value) {
  if (typeof value === "bigint") return value.toString();
  if (ArrayBuffer.isView(value) || Array.isArray(value)) return `[${Array.from(value, json).join()}]`;
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value).map(([name, inner]) => `${JSON.stringify(name)}:${json(inner)}`).join()}}`;
}

function decoder(schema) {
  assert.strictEqual(schema.encoding, "ros2msg");
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  return new MessageReader(definitions);
}

function show(schema, channel, decode, message) {
  assert.strictEqual(channel.messageEncoding, "cdr");
  const value = decode.readMessage(message.data);
  assert(message.data.length - decode.lastReadByteLength() <= 3, "the definition does not cover the message");
  return json({
    topic: channel.topic, type: schema.name, sequence: message.sequence, log_time: message.logTime,
    publish_time: message.publishTime, value, qos: channel.metadata.get("offered_qos_profiles"),
  });
}

function fromBegin(content, decompressHandlers) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const [schemas, channels, decoders, shown] = [new Map(), new Map(), new Map(), []];
  reader.append(content);
  for (let record; (record = reader.nextRecord()) != undefined; ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type !== "Message") continue;
    const channel = channels.get(record.channelId);
    const schema = schemas.get(channel.schemaId);
    if (!decoders.has(schema.id)) decoders.set(schema.id, decoder(schema));
    shown.push(show(schema, channel, decoders.get(schema.id), record));
  }
  assert(reader.done(), "the file has no end");
  return shown;
}

async function byIndex(content, decompressHandlers) {
  const readable = {
    size: async () => BigInt(content.length),
    read: async (offset, size) => content.subarray(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const shown = [];
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    shown.push(show(schema, channel, decoder(schema), message));
  }
  assert.strictEqual(reader.statistics.messageCount, BigInt(shown.length));
  return shown;
}

async function main(file) {
  await zstd.isLoaded;
  await lz4.isLoaded;
  const decompressHandlers = {
    lz4: (data, size) => lz4(data, Number(size)),
    zstd: (data, size) => zstd.decompress(data, Number(size)),
  };
  const content = new Uint8Array(fs.readFileSync(file));
  const shown = fromBegin(content, decompressHandlers);
  assert.deepStrictEqual([...shown].sort(), (await byIndex(content, decompressHandlers)).sort());
  process.stdout.write(shown.map((line) => `${line}\n`).join(""));
}

main(process.argv[2]).catch((error) => {
  console.error(error);
  process.exitCode = 1;
});
