// Read a recording by the packages that Foxglove and Lichtblick read files by, message by message.
//
//   node read.js indexed|streamed FILE
//
// A line of JSON for each message: its topic, time, and what it says. Both ways are taken by those
// viewers: by its index, where a file has one, else from its beginning to its end.

import { readFileSync } from "node:fs";

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import protobuf from "protobufjs";
import descriptors from "protobufjs/ext/descriptor/index.js";

const [way, path] = process.argv.slice(2);
const data = readFileSync(path);
const decompressHandlers = await loadDecompressHandlers();

async function* indexed() {
  const readable = {
    size: async () => BigInt(data.length),
    read: async (at, size) => new Uint8Array(data.subarray(Number(at), Number(at + size))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    yield [channel, reader.schemasById.get(channel.schemaId), message];
  }
}

async function* streamed() {
  const reader = new McapStreamReader({ decompressHandlers });
  const schemas = new Map();
  const channels = new Map();
  reader.append(data);
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") {
      schemas.set(record.id, record);
    } else if (record.type === "Channel") {
      channels.set(record.id, record);
    } else if (record.type === "Message") {
      const channel = channels.get(record.channelId);
      yield [channel, schemas.get(channel.schemaId), record];
    }
  }
}

// What decodes the messages of a channel, by the schema in the file.
function decoder(channel, schema) {
  if (channel.messageEncoding === "json") {
    return (bytes) => JSON.parse(new TextDecoder().decode(bytes));
  }
  const root = protobuf.Root.fromDescriptor(descriptors.FileDescriptorSet.decode(schema.data));
  const type = root.lookupType(schema.name);
  return (bytes) => type.toObject(type.decode(bytes), { longs: Number, defaults: true });
}

const decoders = new Map();
for await (const [channel, schema, message] of way === "indexed" ? indexed() : streamed()) {
  if (!decoders.has(channel.id)) {
    decoders.set(channel.id, decoder(channel, schema));
  }
  const data = decoders.get(channel.id)(message.data);
  console.log(JSON.stringify({ topic: channel.topic, time: String(message.logTime), data }));
}
