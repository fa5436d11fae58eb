#include "tools/recording/mcap_reader.h"

#include <algorithm>
#include <array>
#include <utility>

#include "tools/recording/compression.h"

namespace sft::recording {

namespace {

// The size of the pieces in which messages without a chunk are read
constexpr std::uint64_t run_bytes = std::uint64_t{1} << 20;
constexpr std::uint64_t texts_most = 16;  // the limit of all definitions, as a multiple of Limits::text_bytes
// The size of the part of a chunk before the name of its compression
constexpr std::size_t chunk_head_bytes = 8 + 8 + 8 + 4 + 4;

const char* name_of_kind(Opcode opcode) {
  constexpr std::array names = {"Record",     "Header",        "Footer",          "Schema",
                                "Channel",    "Message",       "Chunk",           "MessageIndex",
                                "ChunkIndex", "Attachment",    "AttachmentIndex", "Statistics",
                                "Metadata",   "MetadataIndex", "SummaryOffset",   "DataEnd"};
  const auto kind = static_cast<std::size_t>(opcode);
  return kind < names.size() ? names[kind] : "Record";
}

/// The identifier that schemas, channels and messages begin with.
std::uint16_t id_of(std::span<const std::byte> content) {
  return ByteReader(content).number<std::uint16_t>();
}

}  // namespace

Result<std::unique_ptr<McapReader>> McapReader::open(File file, const Limits& limits) {
  const auto begin = file.look(0, magic.size());
  if (!std::ranges::equal(begin, bytes_of(magic))) {
    return fail(Errc::malformed,
                "'" + file.name() + "' is no MCAP file: it does not begin with its magic bytes");
  }
  std::unique_ptr<McapReader> reader(new McapReader(std::move(file), limits));
  reader->scan();
  reader->rewind(0, nullptr);
  return reader;
}

std::string McapReader::name(Opcode opcode, std::uint64_t offset) const {
  return std::string(name_of_kind(opcode)) + " at offset " + std::to_string(offset);
}

std::string McapReader::format() const {
  std::string text = "MCAP";
  if (!found_.profile.empty()) text += ", profile " + found_.profile;
  if (!found_.library.empty()) text += ", by " + found_.library;
  return text;
}

// ---- the walk over the file ----

void McapReader::scan() {
  const bool is_whole = scan_from(magic.size(), file_.size());
  if (!is_whole || !found_.footer) go_on_by_index();
  std::ranges::stable_sort(found_.places, {}, &Place::first_ns);
  for (Place& place : found_.places) {
    if (const auto indexed = found_.indexed.find(place.offset); indexed != found_.indexed.end())
      place.channels = indexed->second.channels;
  }
  if (!found_.footer) return add_fault("the file has no end: it was not finished, or was cut off");
  if (!std::ranges::equal(file_.look(file_.size() - magic.size(), magic.size()), bytes_of(magic)))
    add_fault("the file does not end with its magic bytes");
}

/// Visits the records. Returns false if the walk had to end early because of a fault.
bool McapReader::scan_from(std::uint64_t offset, std::uint64_t end) {
  while (offset < end && !found_.footer) {
    ByteReader head(file_.look(offset, record_head_bytes));
    const auto opcode = head.number<std::uint8_t>();
    const auto length = head.number<std::uint64_t>();
    if (!head.is_good() || end - offset < record_head_bytes) {
      add_fault("the record at offset " + std::to_string(offset) + " is cut off");
      return false;
    }
    const std::uint64_t left = end - offset - record_head_bytes;
    if (length > left || opcode == 0) {
      add_fault(name(static_cast<Opcode>(opcode), offset) +
                (opcode == 0 ? ": there is no record of the kind 0"
                             : ": it names " + std::to_string(length) + " bytes, and the file has " +
                                   std::to_string(left) + " more"));
      return false;
    }
    if (!scan_record(static_cast<Opcode>(opcode), offset, length)) return false;
    offset += record_head_bytes + length;
  }
  return true;
}

bool McapReader::scan_record(Opcode opcode, std::uint64_t offset, std::uint64_t length) {
  const std::uint64_t content = offset + record_head_bytes;
  switch (opcode) {
    case Opcode::message:
      add_to_run(offset, length);
      return true;
    case Opcode::chunk:
      return scan_chunk(offset, length);
    case Opcode::message_index:
      if (!found_.places.empty() && found_.places.back().index_end == offset)
        found_.places.back().index_end = content + length;
      return true;
    case Opcode::attachment: {
      // Only the part before the data is read, because the data may be large.
      ByteReader from(file_.look(content, static_cast<std::size_t>(std::min<std::uint64_t>(length, 4096))));
      from.raw(16);
      const std::string label(from.text());
      from.text();
      overview_.attachments[label] = from.number<std::uint64_t>();
      found_.attachments.emplace_back(content, length);
      return true;
    }
    case Opcode::header:
    case Opcode::footer:
    case Opcode::schema:
    case Opcode::channel:
    case Opcode::metadata:
    case Opcode::chunk_index:
    case Opcode::statistics:
    case Opcode::data_end: {
      if (length > limits_.text_bytes) {
        add_fault(name(opcode, offset) + ": " + std::to_string(length) + " bytes are too many");
        return true;
      }
      const Result<Bytes> bytes = file_.read(content, length);
      if (!bytes) {
        add_fault(name(opcode, offset) + ": " + bytes.error().message);
        return false;
      }
      scan_content(opcode, offset, *bytes);
      return true;
    }
    default:
      return true;  // other records are an index in the summary, or belong to a later version
  }
}

void McapReader::scan_content(Opcode opcode, std::uint64_t offset, std::span<const std::byte> content) {
  const bool is_new_schema = opcode == Opcode::schema && !schemas_.contains(id_of(content));
  const bool is_new_channel = opcode == Opcode::channel && !channels_.contains(id_of(content));
  if (is_new_schema || is_new_channel) definition_bytes_ += content.size();
  if (content.size() > limits_.text_bytes || definition_bytes_ > texts_most * limits_.text_bytes) {
    if (is_new_schema || is_new_channel) definition_bytes_ -= content.size();
    return add_fault(name(opcode, offset) + ": " + std::to_string(content.size()) + " bytes are too many");
  }
  ByteReader from(content);
  if (opcode == Opcode::header) {
    found_.profile = from.text();
    found_.library = from.text();
  } else if (opcode == Opcode::footer) {
    Footer footer{.summary = from.number<std::uint64_t>()};
    from.number<std::uint64_t>();
    footer.crc = from.number<std::uint32_t>();
    found_.footer = footer;
  } else if (opcode == Opcode::schema) {
    Schema schema{.id = from.number<std::uint16_t>()};
    schema.name = from.text();
    schema.encoding = from.text();
    schema.data = from.text();
    if (from.is_good()) add(std::move(schema), name(opcode, offset));
  } else if (opcode == Opcode::channel) {
    Channel channel{.id = from.number<std::uint16_t>()};
    channel.schema = from.number<std::uint16_t>();
    channel.topic = from.text();
    channel.encoding = from.text();
    channel.metadata = from.texts();
    if (from.is_good()) add(std::move(channel), name(opcode, offset));
    found_.has_summary_channels |= found_.data_end != 0;
  } else if (opcode == Opcode::metadata) {
    const std::string label(from.text());
    Texts texts = from.texts();
    if (from.is_good()) overview_.metadata[label] = std::move(texts);
  } else if (opcode == Opcode::chunk_index) {
    add_chunk_index(from);
  } else if (opcode == Opcode::statistics) {
    add_statistics(from);
  } else if (opcode == Opcode::data_end) {
    found_.data_end = offset;
    found_.data_crc = from.number<std::uint32_t>();
  }
  if (!from.is_good()) add_fault(name(opcode, offset) + ": its content ends early");
}

bool McapReader::scan_chunk(std::uint64_t offset, std::uint64_t length) {
  const std::uint64_t content = offset + record_head_bytes;
  const std::size_t most = chunk_head_bytes + 256 + 8;  // with the longest name of a compression
  ByteReader from(file_.look(content, static_cast<std::size_t>(std::min<std::uint64_t>(length, most))));
  Place place{.offset = offset, .is_chunk = true};
  place.first_ns = from.number<std::uint64_t>();
  place.last_ns = from.number<std::uint64_t>();
  place.size = from.number<std::uint64_t>();
  place.crc = from.number<std::uint32_t>();
  place.compression = from.text();
  place.data_bytes = from.number<std::uint64_t>();
  place.data_offset = content + chunk_head_bytes + place.compression.size() + 8;
  const std::uint64_t end = content + length;
  place.index_end = end;
  if (!from.is_good() || place.data_offset > end || place.data_bytes > end - place.data_offset) {
    add_fault(name(Opcode::chunk, offset) + ": its content is longer than the record; it is left out");
    return true;
  }
  ++overview_.chunks[place.compression.empty() ? "none" : place.compression];
  found_.places.push_back(std::move(place));
  return true;
}

void McapReader::add_to_run(std::uint64_t offset, std::uint64_t length) {
  ByteReader from(file_.look(offset + record_head_bytes, message_head_bytes));
  from.raw(6);
  const auto time = from.number<std::uint64_t>();
  if (length < message_head_bytes || !from.is_good())
    return add_fault(name(Opcode::message, offset) + ": its content ends early");
  const std::uint64_t bytes = record_head_bytes + length;
  Place* run = found_.places.empty() ? nullptr : &found_.places.back();
  if (run == nullptr || run->is_chunk || run->data_offset + run->size != offset ||
      run->size + bytes > run_bytes) {
    found_.places.push_back({.offset = offset, .data_offset = offset, .first_ns = time, .last_ns = time});
    run = &found_.places.back();
  }
  run->size = run->data_bytes = run->size + bytes;
  run->first_ns = std::min(run->first_ns, time);
  run->last_ns = std::max(run->last_ns, time);
}

void McapReader::add_chunk_index(ByteReader from) {
  Place place{.is_chunk = true};
  place.first_ns = from.number<std::uint64_t>();
  place.last_ns = from.number<std::uint64_t>();
  place.offset = from.number<std::uint64_t>();
  from.number<std::uint64_t>();
  ByteReader offsets(from.raw(from.number<std::uint32_t>()));
  while (!offsets.at_end() && offsets.is_good()) {
    place.channels.insert(offsets.number<std::uint16_t>());
    offsets.number<std::uint64_t>();
  }
  from.number<std::uint64_t>();
  place.compression = from.text();
  place.data_bytes = from.number<std::uint64_t>();
  place.size = from.number<std::uint64_t>();
  if (from.is_good()) found_.indexed[place.offset] = std::move(place);
}

void McapReader::add_statistics(ByteReader from) {
  Statistics statistics{.messages = from.number<std::uint64_t>()};
  from.raw(2 + 4 + 4 + 4);
  statistics.chunks = from.number<std::uint32_t>();
  statistics.first_ns = from.number<std::uint64_t>();
  statistics.last_ns = from.number<std::uint64_t>();
  ByteReader counts(from.raw(from.number<std::uint32_t>()));
  while (!counts.at_end() && counts.is_good()) {
    const auto channel = counts.number<std::uint16_t>();
    statistics.of_channel[channel] = counts.number<std::uint64_t>();
  }
  if (from.is_good() && counts.is_good()) found_.statistics = std::move(statistics);
}

/// Continues after damaged bytes by means of the summary at the end of the file, which lists all chunks.
void McapReader::go_on_by_index() {
  const std::uint64_t tail = record_head_bytes + 20 + magic.size();
  if (found_.footer || file_.size() < tail + magic.size()) return;
  const std::uint64_t at = file_.size() - tail;
  ByteReader from(file_.look(at, static_cast<std::size_t>(tail)));
  const auto opcode = from.number<std::uint8_t>();
  const auto length = from.number<std::uint64_t>();
  const auto summary = from.number<std::uint64_t>();
  if (opcode != static_cast<std::uint8_t>(Opcode::footer) || length != 20 || summary < magic.size() ||
      summary >= at)
    return;
  if (found_.data_end == 0) found_.data_end = summary;
  scan_from(summary, file_.size() - magic.size());
  std::set<std::uint64_t> known;
  for (const Place& place : found_.places) known.insert(place.offset);
  for (const auto& [offset, indexed] : found_.indexed) {
    ByteReader head(file_.look(offset, record_head_bytes));
    const auto kind = head.number<std::uint8_t>();
    const auto bytes = head.number<std::uint64_t>();
    const bool is_there = head.is_good() && kind == static_cast<std::uint8_t>(Opcode::chunk) &&
                          bytes <= file_.size() - offset - record_head_bytes;
    if (is_there && !known.contains(offset)) scan_chunk(offset, bytes);
  }
}

// ---- reading messages ----

void McapReader::rewind(std::uint64_t from_ns, const std::set<std::uint16_t>* only) {
  open_.clear();
  given_ = open_.end();
  next_place_ = 0;
  reread_ = 0;
  from_ns_ = from_ns;
  only_ = only == nullptr ? std::nullopt : std::optional(*only);
}

/// Returns the uncompressed records of the place. Reports faults in them.
std::optional<Bytes> McapReader::bytes_of_place(const Place& place) {
  const std::string label = name(place.is_chunk ? Opcode::chunk : Opcode::message, place.offset);
  if (place.size > limits_.chunk_bytes || place.data_bytes > limits_.chunk_bytes) {
    add_fault(label + ": " + std::to_string(std::max(place.size, place.data_bytes)) +
              " bytes are more than a reader keeps in memory; it is left out");
    return std::nullopt;
  }
  Result<Bytes> bytes = file_.read(place.data_offset, place.data_bytes);
  if (bytes && (!place.compression.empty() || bytes->size() != place.size))
    bytes = decompress(place.compression, *bytes, place.size);
  if (bytes && place.crc != 0 && crc32(0, *bytes) != place.crc)
    bytes = fail(Errc::malformed, "its checksum is wrong");
  if (bytes) return *std::move(bytes);
  add_fault(label + ": " + bytes.error().message + "; it is left out");
  return std::nullopt;
}

/// Returns true if a record says what the channel is. The places are read in the order of their times. In a
/// file without a summary, the record may be in a place of later times. So when a channel is not known, the
/// records of all places are read, once.
bool McapReader::knows(std::uint16_t channel) {
  if (channels_.contains(channel)) return true;
  if (std::exchange(has_all_definitions_, true)) return false;
  for (const Place& place : found_.places) {
    const std::optional<Bytes> bytes = is_stopped() ? std::nullopt : bytes_of_place(place);
    if (!bytes) continue;
    const auto record = [&](Opcode opcode, std::span<const std::byte> content, std::uint64_t offset) {
      if (opcode == Opcode::schema || opcode == Opcode::channel)
        scan_content(opcode, place.is_chunk ? place.offset : place.offset + offset, content);
    };
    walk(*bytes, {record, [](std::uint64_t, const std::string&) {}});
  }
  return channels_.contains(channel);
}

std::optional<Block> McapReader::opened(const Place& place) {
  std::optional<Bytes> bytes = bytes_of_place(place);
  if (!bytes) return std::nullopt;
  Block block{.place = &place};
  const auto record = [&](Opcode opcode, std::span<const std::byte> content, std::uint64_t offset) {
    Message message;
    if (opcode == Opcode::schema || opcode == Opcode::channel) {
      scan_content(opcode, place.is_chunk ? place.offset : place.offset + offset, content);
    } else if (opcode == Opcode::message) {
      if (!read_message(content, message)) {
        add_fault(name(Opcode::chunk, place.offset) + ": a message at " + std::to_string(offset) +
                  " in it ends early");
      } else if (!knows(message.channel)) {
        add_fault("channel " + std::to_string(message.channel) +
                  " has messages, but no record that says what it is; they are left out");
      } else if (message.log_ns >= from_ns_ && (!only_ || only_->contains(message.channel))) {
        block.entries.push_back({message.log_ns, offset});
      }
    }
  };
  walk(*bytes,
       {record, [&](std::uint64_t offset, const std::string& what) {
          add_fault(name(Opcode::chunk, place.offset) + ": at " + std::to_string(offset) + " in it " + what);
        }});
  if (block.entries.empty()) return std::nullopt;
  std::ranges::stable_sort(block.entries, {}, &Block::Entry::log_ns);
  block.bytes = *std::move(bytes);
  return block;
}

/// Reads each place that may have the next message.
void McapReader::open_due_blocks() {
  while (next_place_ < found_.places.size()) {
    const Place& place = found_.places[next_place_];
    const auto first = std::ranges::min_element(open_, {}, &Block::time);
    if (first != open_.end() && first->time() < place.first_ns) return;
    ++next_place_;
    const bool is_wanted = !only_ || place.channels.empty() ||
                           std::ranges::any_of(place.channels, [&](auto id) { return only_->contains(id); });
    if (place.last_ns < from_ns_ || !is_wanted) continue;
    if (is_stopped()) {
      next_place_ = found_.places.size();
      return open_.clear();
    }
    std::optional<Block> block = opened(place);
    if (!block) continue;
    open_.push_back(*std::move(block));
    keep_within_memory(open_.back());
  }
}

/// Reads the block again for the messages that were dropped from memory. Returns false if they cannot be
/// read.
bool McapReader::reopen(Block& block) {
  const Place& place = *block.place;
  reread_ += place.size;
  if (reread_ > limits_.reread_bytes) {
    add_fault(name(Opcode::chunk, place.offset) +
              ": it overlaps with others in time, and all of them are too large to be read together; "
              "its rest is left out");
    return false;
  }
  const std::uint64_t before = block.before + block.entries.size();
  block.bytes = Bytes();
  std::optional<Block> read = is_stopped() ? std::nullopt : opened(place);
  if (!read || read->entries.size() <= before) return false;
  block = *std::move(read);
  block.at = static_cast<std::size_t>(before);
  keep_within_memory(block);
  return true;
}

/// Limits each block to an equal part of the memory if all blocks together need more than the limit.
void McapReader::keep_within_memory(const Block& in_use) {
  std::uint64_t total = 0;
  for (const Block& block : open_) total += block.memory();
  if (total <= limits_.memory_bytes || open_.size() == 1) return;
  const std::uint64_t part = limits_.memory_bytes / open_.size();
  for (Block& block : open_) {
    if (block.memory() > part) block.shorten(part, &block == &in_use ? 1 : 0);
  }
}

std::optional<Message> McapReader::next() {
  if (given_ != open_.end() && given_->is_empty() && !given_->has_rest) open_.erase(given_);
  given_ = open_.end();
  for (;;) {
    open_due_blocks();
    const auto first = std::ranges::min_element(open_, {}, &Block::time);
    if (first == open_.end()) return std::nullopt;
    if (first->is_empty() && !reopen(*first)) {
      open_.erase(first);
      continue;
    }
    const std::uint64_t offset = first->entries[first->at++].offset;
    ByteReader from(std::span(first->bytes).subspan(static_cast<std::size_t>(offset) + 1));
    Message message;
    // The bytes are checked again, because the file may have changed since it was first read.
    if (!read_message(from.raw(from.number<std::uint64_t>()), message) ||
        !channels_.contains(message.channel)) {
      add_fault("the file changes while it is read");
      open_.erase(first);
      continue;
    }
    given_ = first;
    return message;
  }
}

const Overview& McapReader::overview() {
  if (std::exchange(is_counted_, true)) return overview_;
  const bool is_known = found_.statistics && found_.has_summary_channels &&
                        (found_.statistics->messages == 0 || !found_.statistics->of_channel.empty());
  if (!is_known || !faults().empty()) {
    count();
    return overview_;
  }
  overview_.messages = found_.statistics->messages;
  overview_.first_ns = found_.statistics->first_ns;
  overview_.last_ns = found_.statistics->last_ns;
  overview_.of_channel = found_.statistics->of_channel;
  return overview_;
}

void McapReader::read_attachments(const std::function<void(const Bytes&)>& each) {
  for (const auto& [offset, length] : found_.attachments) {
    const std::string label = name(Opcode::attachment, offset - record_head_bytes);
    if (length > limits_.chunk_bytes) {
      add_fault(label + ": it is larger than a reader keeps in memory; it is left out");
      continue;
    }
    Result<Bytes> content = file_.read(offset, length);
    const std::size_t data =
        length < sizeof(std::uint32_t) ? 0 : static_cast<std::size_t>(length) - sizeof(std::uint32_t);
    std::uint32_t crc = 0;
    if (content && data > 0) std::memcpy(&crc, content->data() + data, sizeof crc);
    if (content && crc != 0 && crc32(0, std::span(*content).first(data)) != crc)
      content = fail(Errc::malformed, "its checksum is wrong");
    if (content)
      each(*content);
    else
      add_fault(label + ": " + content.error().message + "; it is left out");
  }
}

void McapReader::count() {
  rewind(0, nullptr);
  for (const Place& place : found_.places) {
    if (is_stopped()) return;
    const std::optional<Block> block = opened(place);
    if (!block) continue;
    const std::uint64_t first_ns = block->entries.front().log_ns;
    overview_.first_ns = overview_.messages == 0 ? first_ns : std::min(overview_.first_ns, first_ns);
    overview_.last_ns = std::max(overview_.last_ns, block->entries.back().log_ns);
    overview_.messages += block->entries.size();
    for (const Block::Entry& entry : block->entries) {
      const auto record = std::span(block->bytes).subspan(static_cast<std::size_t>(entry.offset));
      ++overview_.of_channel[id_of(record.subspan(record_head_bytes))];
    }
  }
}

}  // namespace sft::recording
