#include "tools/recording/block.h"

#include <utility>

namespace sft::recording {

void walk(std::span<const std::byte> bytes, const RecordVisitor& visitor) {
  for (std::uint64_t offset = 0; offset < bytes.size();) {
    ByteReader head(bytes.subspan(static_cast<std::size_t>(offset)));
    const auto opcode = head.number<std::uint8_t>();
    const auto length = head.number<std::uint64_t>();
    if (!head.is_good()) return visitor.fault(offset, "the head of a record is cut off");
    if (length > head.left()) {
      return visitor.fault(offset, "a record names " + std::to_string(length) + " bytes, and " +
                                       std::to_string(head.left()) + " are left");
    }
    if (opcode == 0) return visitor.fault(offset, "there is no record of the kind 0");
    visitor.record(static_cast<Opcode>(opcode), head.raw(length), offset);
    offset += record_head_bytes + length;
  }
}

void Block::shorten(std::uint64_t most, std::size_t least) {
  Bytes kept;
  std::vector<Entry> kept_entries;
  before += at;
  for (; !is_empty(); ++at) {
    const std::span<const std::byte> record =
        std::span<const std::byte>(bytes).subspan(static_cast<std::size_t>(entries[at].offset));
    ByteReader head(record.subspan(1));
    const std::uint64_t length = record_head_bytes + head.number<std::uint64_t>();
    const std::uint64_t memory = kept.size() + length + (kept_entries.size() + 1) * sizeof(Entry);
    if (memory > most && kept_entries.size() >= least) {
      has_rest = true;
      rest_ns = time();
      break;
    }
    kept_entries.push_back({time(), kept.size()});
    kept.insert(kept.end(), record.begin(), record.begin() + static_cast<std::ptrdiff_t>(length));
  }
  kept.shrink_to_fit();
  bytes = std::move(kept);
  entries = std::move(kept_entries);
  at = 0;
}

bool read_message(std::span<const std::byte> content, Message& message) {
  ByteReader from(content);
  message.channel = from.number<std::uint16_t>();
  message.sequence = from.number<std::uint32_t>();
  message.log_ns = from.number<std::uint64_t>();
  message.publish_ns = from.number<std::uint64_t>();
  message.data = from.raw(from.left());
  return from.is_good();
}

}  // namespace sft::recording
