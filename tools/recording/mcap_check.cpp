// McapReader::check() compares the indexes, checksums and statistics of a file with its records.
#include <algorithm>
#include <set>
#include <utility>

#include "tools/recording/compression.h"
#include "tools/recording/mcap_reader.h"

namespace sft::recording {

void McapReader::check() {
  std::map<std::uint16_t, std::uint64_t> counted;
  rewind(0, nullptr);
  for (const Place& place : found_.places) {
    if (is_stopped()) return;
    check_place(place, counted);
  }
  read_attachments([](const Bytes&) {});
  check_summary(counted);
  if (found_.footer && found_.footer->summary != 0 && found_.data_end == 0)
    add_fault("the file has a summary, but no DataEnd record in front of it");
  if (found_.data_end != 0) check_crc("the data section", 0, found_.data_end, found_.data_crc);
  if (found_.footer && found_.footer->summary != 0) {
    const std::uint64_t end = file_.size() - magic.size() - sizeof(std::uint32_t);
    check_crc("the summary", found_.footer->summary, end, found_.footer->crc);
  }
}

void McapReader::check_place(const Place& place, std::map<std::uint16_t, std::uint64_t>& counted) {
  const std::optional<Bytes> bytes = bytes_of_place(place);
  if (!bytes) return;
  const std::string label = name(place.is_chunk ? Opcode::chunk : Opcode::message, place.offset);
  std::uint64_t messages = 0;
  std::uint64_t first = UINT64_MAX, last = 0;
  const auto record = [&](Opcode opcode, std::span<const std::byte> content, std::uint64_t) {
    Message message;
    if (opcode == Opcode::schema || opcode == Opcode::channel) scan_content(opcode, place.offset, content);
    if (opcode != Opcode::message) return;
    if (!read_message(content, message)) return add_fault(label + ": a message in it ends early");
    if (!knows(message.channel)) add_fault(label + ": a message in it is of no known channel");
    ++messages;
    ++counted[message.channel];
    first = std::min(first, message.log_ns);
    last = std::max(last, message.log_ns);
  };
  walk(*bytes, {record, [&](std::uint64_t offset, const std::string& what) {
                  add_fault(label + ": at " + std::to_string(offset) + " in it " + what);
                }});
  if (!place.is_chunk) return;
  const bool has_times = messages == 0 || (first == place.first_ns && last == place.last_ns);
  if (!has_times) add_fault(label + ": its first and last times are not those of its messages");
  check_indexes(place, *bytes, messages);
}

/// Compares the message indexes after a chunk with the messages in it.
void McapReader::check_indexes(const Place& place, const Bytes& bytes, std::uint64_t messages) {
  const std::uint64_t begin = place.data_offset + place.data_bytes;
  if (place.index_end <= begin) return;  // a file may have no indexes
  const std::uint64_t length = place.index_end - begin;
  const Result<Bytes> indexes =
      length > limits_.chunk_bytes ? fail(Errc::malformed, "they are too large") : file_.read(begin, length);
  std::uint64_t indexed = 0;
  bool is_right = indexes.has_value();
  const auto record = [&](Opcode opcode, std::span<const std::byte> content, std::uint64_t) {
    if (opcode != Opcode::message_index) return;
    ByteReader from(content);
    const auto channel = from.number<std::uint16_t>();
    ByteReader entries(from.raw(from.number<std::uint32_t>()));
    while (!entries.at_end() && entries.is_good()) {
      const auto time = entries.number<std::uint64_t>();
      const auto offset = entries.number<std::uint64_t>();
      Message message;
      const auto begin_of_record = static_cast<std::size_t>(std::min<std::uint64_t>(offset, bytes.size()));
      ByteReader at(std::span<const std::byte>(bytes).subspan(begin_of_record));
      const bool is_message = at.number<std::uint8_t>() == static_cast<std::uint8_t>(Opcode::message);
      is_right = is_right && is_message && read_message(at.raw(at.number<std::uint64_t>()), message) &&
                 message.channel == channel && message.log_ns == time;
      ++indexed;
    }
    is_right = is_right && from.is_good() && entries.is_good();
  };
  if (indexes) walk(*indexes, {record, [&](std::uint64_t, const std::string&) { is_right = false; }});
  if (!is_right || indexed != messages)
    add_fault(name(Opcode::chunk, place.offset) +
              ": the message indexes behind it are not those of its messages");
}

void McapReader::check_summary(const std::map<std::uint16_t, std::uint64_t>& counted) {
  std::set<std::uint64_t> chunks;
  for (const Place& place : found_.places) {
    if (!place.is_chunk) continue;
    chunks.insert(place.offset);
    const auto indexed = found_.indexed.find(place.offset);
    if (indexed == found_.indexed.end()) {
      if (!found_.indexed.empty())
        add_fault(name(Opcode::chunk, place.offset) + ": the summary does not have it");
      continue;
    }
    const Place& said = indexed->second;
    if (std::tie(said.first_ns, said.last_ns, said.size, said.data_bytes, said.compression) !=
        std::tie(place.first_ns, place.last_ns, place.size, place.data_bytes, place.compression))
      add_fault(name(Opcode::chunk, place.offset) + ": the summary describes it in another way");
  }
  for (const auto& [offset, place] : found_.indexed) {
    if (!chunks.contains(offset))
      add_fault("the summary names a chunk at " + std::to_string(offset) + ", where none is");
  }
  if (!found_.statistics) return;
  std::uint64_t messages = 0;
  for (const auto& [channel, count] : counted) messages += count;
  if (found_.statistics->messages != messages || found_.statistics->chunks != chunks.size()) {
    add_fault("the statistics count " + std::to_string(found_.statistics->messages) + " messages in " +
              std::to_string(found_.statistics->chunks) + " chunks, and there are " +
              std::to_string(messages) + " in " + std::to_string(chunks.size()));
  } else if (!found_.statistics->of_channel.empty()) {
    std::map<std::uint16_t, std::uint64_t> said = found_.statistics->of_channel;
    std::erase_if(said, [](const auto& one) { return one.second == 0; });
    if (said != counted) add_fault("the statistics count other messages of each channel than there are");
  }
}

void McapReader::check_crc(const char* what, std::uint64_t begin, std::uint64_t end, std::uint32_t crc) {
  constexpr std::uint64_t piece = std::uint64_t{1} << 22;
  std::uint32_t found = 0;
  if (crc == 0) return;
  if (begin > end) return add_fault(std::string(what) + " begins behind its end");
  while (begin < end) {
    if (is_stopped()) return;
    const std::uint64_t length = std::min(piece, end - begin);
    const Result<Bytes> bytes = file_.read(begin, length);
    if (!bytes) return add_fault(std::string(what) + ": " + bytes.error().message);
    found = crc32(found, *bytes);
    begin += length;
  }
  if (found != crc) add_fault(std::string("the checksum of ") + what + " is wrong");
}

}  // namespace sft::recording
