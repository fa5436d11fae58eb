#include "core/vanilla/raw_sample.h"

#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/q_protocol.h>
#include <dds/ddsi/q_radmin.h>
#include <dds/ddsrt/heap.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#include "sft/detail/convert.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/walk.h"

namespace sft::core {

namespace {

struct RawType : ddsi_sertype {
  RawReading reading{};
};

/// A sample as Cyclone DDS handles it. The encapsulation lies before the body in the memory of the sample.
struct RawSample : ddsi_serdata {
  SampleHandle sample{};
  std::uint64_t sequence = 0;  ///< the number of a received sample; 0: unknown
  RawFault fault = RawFault::none;
  const std::byte* bytes = nullptr;  ///< the encapsulation and the body
  std::size_t size = 0;              ///< the size of both in bytes
  std::size_t readable = 0;          ///< `size`, plus the bytes after the body in the same memory
};

const RawSample& of(const ddsi_serdata* data) { return *static_cast<const RawSample*>(data); }

RawSample* make(const ddsi_sertype* type, ddsi_serdata_kind kind) {
  auto* const data = new RawSample{};
  ddsi_serdata_init(data, type, kind);
  data->hash = type->serdata_basehash;  // all hashes are equal, because the topic has only one instance
  return data;
}

/// Copies bytes of a sample. Cyclone requests sizes that are multiples of 4; bytes after the end are 0.
void copy_out(const ddsi_serdata* data, std::size_t offset, std::size_t bytes, void* to) {
  const RawSample& sample = of(data);
  const std::size_t there = offset < sample.size ? std::min(bytes, sample.size - offset) : 0;
  if (there > 0) std::memcpy(to, sample.bytes + offset, there);
  std::memset(static_cast<std::byte*>(to) + there, 0, bytes - there);
}

/// Makes `piece` refer to the bytes of the sample. The bytes are copied only if the padding of the last
/// piece would lie outside of the sample's memory.
ddsi_serdata* refer_to(const ddsi_serdata* data, std::size_t offset, std::size_t bytes,
                       ddsrt_iovec_t* piece) {
  const RawSample& sample = of(data);
  piece->iov_len = bytes;
  if (offset + bytes <= sample.readable) {
    piece->iov_base = const_cast<std::byte*>(sample.bytes + offset);
  } else {
    piece->iov_base = ddsrt_malloc(bytes);
    copy_out(data, offset, bytes, piece->iov_base);
  }
  return ddsi_serdata_ref(data);
}

void refer_no_more(ddsi_serdata* data, const ddsrt_iovec_t* piece) {
  const RawSample& sample = of(data);
  const auto* const begin = static_cast<const std::byte*>(piece->iov_base);
  const bool lies_in_sample = begin >= sample.bytes && begin < sample.bytes + sample.readable;
  if (!lies_in_sample) ddsrt_free(piece->iov_base);
  ddsi_serdata_unref(data);
}

ddsi_serdata* without_type(const ddsi_serdata* data) {
  RawSample* const key = make(data->type, SDK_KEY);
  key->type = nullptr;
  return key;
}

void refer_to_bytes(RawSample& data, std::size_t slots) {
  const detail::SampleState state = state_of(*data.sample, slots);
  data.bytes = state.body - detail::encapsulation_bytes;
  data.size = state.body_bytes + detail::encapsulation_bytes;
  data.readable = static_cast<std::size_t>(data.sample->data + data.sample->capacity - data.bytes);
}

/// Calls `use` for the bytes of each fragment in order, without bytes that an earlier fragment contained,
/// too.
template <class Use>
void for_each_piece(const nn_rdata* fragments, Use use) {
  std::size_t done = 0;
  for (; fragments != nullptr; fragments = fragments->nextfrag) {
    if (fragments->maxp1 <= done) continue;
    const unsigned char* const payload = NN_RMSG_PAYLOADOFF(fragments->rmsg, NN_RDATA_PAYLOAD_OFF(fragments));
    use(done, payload + (done - fragments->min), fragments->maxp1 - done);
    done = fragments->maxp1;
  }
}

/// Returns the sequence number of the message, which Cyclone has already converted to the byte order of
/// this host.
std::uint64_t sequence_of(const nn_rdata& first) {
  if (NN_RDATA_SUBMSG_OFF(&first) == 0) return 0;
  const unsigned char* const message = NN_RMSG_PAYLOADOFF(first.rmsg, NN_RDATA_SUBMSG_OFF(&first));
  nn_sequence_number_t number;
  std::memcpy(&number, message + offsetof(Data_DataFrag_common_t, writerSN), sizeof number);
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(number.high)) << 32) | number.low;
}

using Encapsulation = std::array<unsigned char, detail::encapsulation_bytes>;

/// Returns true if the encoding is XCDR1: the second byte of the encapsulation is 0 or 1. The number of
/// padding bytes, in the fourth byte, is not needed.
bool is_xcdr1(const Encapsulation& head) { return head[0] == 0 && head[1] <= 1; }
bool is_big_endian(const Encapsulation& head) { return head[1] == 0; }

std::size_t slots_of(const RawReading& reading) {
  return reading.type == nullptr ? 0 : reading.type->index_slots();
}

std::byte* body_of(const SampleHandle& sample, const RawReading& reading) {
  return sample->data + detail::SampleLayout(slots_of(reading)).body_offset;
}

/// Makes a sample for a body of this size. The caller copies the body into it.
SampleHandle room_for(std::size_t body_bytes, const RawReading& reading) {
  const std::size_t slots = slots_of(reading);
  const detail::SampleLayout layout(slots);
  if (body_bytes > std::numeric_limits<std::uint32_t>::max() - layout.body_offset) return {};
  SampleHandle sample = reading.memory->take(layout.bytes(body_bytes), reading.memory->limit_bytes() / 4);
  if (!sample) return {};
  sample->mask = reading.type == nullptr ? FieldMask() : reading.type->full();
  sample->parts = 0;
  detail::SampleHeader& header = sample->header();
  header.index_slots = static_cast<std::uint16_t>(slots);
  header.type_hash = reading.type == nullptr ? 0 : reading.type->hash();
  header.body_offset = static_cast<std::uint32_t>(layout.body_offset);
  header.body_bytes = static_cast<std::uint32_t>(body_bytes);
  std::memcpy(sample->data + layout.body_offset - detail::encapsulation_bytes,
              detail::encapsulation_cdr_le.data(), detail::encapsulation_bytes);
  return sample;
}

/// Replaces the sample, whose body is big-endian, by a little-endian sample with the same values. This is
/// possible only if the type is known.
RawFault swap_bytes(SampleHandle& sample, const RawReading& reading) {
  if (reading.type == nullptr) return RawFault::other_encoding;
  const StructType& type = reading.type->type();
  const detail::Payload foreign{.body = {body_of(sample, reading), sample->header().body_bytes},
                                .byte_order = std::endian::big};
  const detail::ConvertedSize size = detail::converted_size(foreign, type);
  if (size.status != detail::WalkStatus::ok) return RawFault::malformed;
  SampleHandle swapped = room_for(size.bytes, reading);
  if (!swapped) return RawFault::no_memory;
  const auto status = detail::convert(foreign, type, {body_of(swapped, reading), size.bytes});
  sample = std::move(swapped);
  return status == detail::WalkStatus::ok ? RawFault::none : RawFault::malformed;
}

/// Checks the body, and makes its index. Padding after the last member is cut off.
bool check_and_index(SampleBuffer& sample, const TypeSupport& type) {
  std::uint32_t body_end = 0;
  const detail::WalkStatus status = detail::build_index(state_of(sample, type.index_slots()), type.type(),
                                                        {sample.index(), type.index_slots()}, &body_end);
  sample.header().body_bytes = body_end;
  return status == detail::WalkStatus::ok;
}

RawFault read(RawSample& data, const RawReading& reading, const nn_rdata* fragments, std::size_t size) {
  Encapsulation head{};
  if (size < head.size()) return RawFault::malformed;
  SampleHandle sample = room_for(size - head.size(), reading);
  std::byte* const body = sample ? body_of(sample, reading) : nullptr;
  for_each_piece(fragments, [&](std::size_t at, const unsigned char* piece, std::size_t bytes) {
    bytes = at < size ? std::min(bytes, size - at) : 0;
    for (; bytes > 0 && at < head.size(); --bytes) head[at++] = *piece++;
    if (bytes > 0 && body != nullptr) std::memcpy(body + (at - head.size()), piece, bytes);
  });
  if (!is_xcdr1(head)) return RawFault::other_encoding;
  if (!sample) return RawFault::no_memory;
  if (const RawFault fault = is_big_endian(head) ? swap_bytes(sample, reading) : RawFault::none;
      fault != RawFault::none)
    return fault;
  if (reading.type != nullptr && !check_and_index(*sample, *reading.type)) return RawFault::malformed;
  data.sample = std::move(sample);
  refer_to_bytes(data, slots_of(reading));
  return RawFault::none;
}

/// Makes the sample from received fragments. Samples with faults are delivered, too, so that the reader can
/// count them.
ddsi_serdata* receive(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragments,
                      std::size_t size) try {
  const RawReading& reading = static_cast<const RawType*>(type)->reading;
  if (reading.memory == nullptr) return nullptr;
  RawSample* const data = make(type, kind);
  if (kind != SDK_DATA) return data;
  data->sequence = sequence_of(*fragments);
  data->fault = read(*data, reading, fragments, size);
  return data;
} catch (const std::bad_alloc&) {
  return nullptr;
}

const ddsi_serdata_ops sample_operations = [] {
  ddsi_serdata_ops to{};
  to.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };
  to.get_size = [](const ddsi_serdata* data) { return static_cast<std::uint32_t>(of(data).size); };
  to.from_ser = receive;
  to.from_ser_iov = [](const ddsi_sertype*, ddsi_serdata_kind, ddsrt_msg_iovlen_t, const ddsrt_iovec_t*,
                       std::size_t) -> ddsi_serdata* { return nullptr; };
  to.from_keyhash = [](const ddsi_sertype* type, const ddsi_keyhash*) -> ddsi_serdata* {
    return make(type, SDK_KEY);
  };
  to.from_sample = [](const ddsi_sertype*, ddsi_serdata_kind, const void*) -> ddsi_serdata* {
    return nullptr;
  };
  to.to_ser = copy_out;
  to.to_ser_ref = refer_to;
  to.to_ser_unref = refer_no_more;
  to.to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; };
  to.to_untyped = without_type;
  to.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return false; };
  to.free = [](ddsi_serdata* data) { delete static_cast<RawSample*>(data); };
  to.print = [](const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t bytes) {
    if (bytes > 0) *text = '\0';
    return std::size_t{0};
  };
  to.get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* hash, bool) { std::memset(hash, 0, sizeof *hash); };
  return to;
}();

/// Returns true if two types with one name are equal, which is so if their samples are read in the same
/// way. Types have no description here.
bool reads_alike(const ddsi_sertype* a, const ddsi_sertype* b) {
  const RawReading& one = static_cast<const RawType*>(a)->reading;
  const RawReading& other = static_cast<const RawType*>(b)->reading;
  return one.type == other.type && one.memory == other.memory;
}

const ddsi_sertype_ops type_operations = [] {
  ddsi_sertype_ops to{};
  to.version = ddsi_sertype_v0;
  to.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete static_cast<RawType*>(type);
  };
  to.equal = reads_alike;
  to.hash = [](const ddsi_sertype*) { return 0U; };
  to.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  to.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
  to.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  return to;
}();

}  // namespace

RawTopic raw_topic(dds_entity_t participant, const std::string& name, const std::string& type_name,
                   RawReading reading) {
  auto* const made = new RawType{};
  made->reading = std::move(reading);
  ddsi_sertype_init(made, type_name.c_str(), &type_operations, &sample_operations, true);
  made->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  ddsi_sertype* type = made;
  const dds_entity_t topic =
      dds_create_topic_sertype(participant, name.c_str(), &type, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(made);
  return {topic, type};
}

ddsi_serdata* raw_sample(const ddsi_sertype* type, const SampleHandle& sample, std::size_t slots) {
  RawSample* const data = make(type, SDK_DATA);
  data->sample = sample;
  refer_to_bytes(*data, slots);
  data->timestamp.v = sample->source_stamp_ns;
  data->statusinfo = 0;
  return data;
}

SampleHandle raw_body(std::span<const std::byte> body, const RawReading& reading) {
  SampleHandle sample = room_for(body.size(), reading);
  if (sample && !body.empty())
    std::memcpy(sample->data + sample->header().body_offset, body.data(), body.size());
  return sample;
}

RawArrival raw_arrival(const ddsi_serdata* data) {
  const RawSample& received = of(data);
  return {received.sample, received.sequence, received.fault};
}

}  // namespace sft::core
