#include "core/vanilla/raw_sample.h"

#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/q_radmin.h>
#include <dds/ddsrt/heap.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "sft/detail/sample_format.h"

namespace sft::core {

namespace {

struct RawType : ddsi_sertype {};

/// The encapsulation lies before the body in the memory of each sample.
struct RawSample : ddsi_serdata {
  SampleHandle sample{};
  const std::byte* bytes = nullptr;  ///< encapsulation and body
  std::size_t size = 0;              ///< of both
  std::size_t readable = 0;          ///< `size`, and what lies behind in the same memory
};

const RawSample& of(const ddsi_serdata* data) { return *static_cast<const RawSample*>(data); }

RawSample* make(const ddsi_sertype* type, ddsi_serdata_kind kind) {
  auto* const data = new RawSample{};
  ddsi_serdata_init(data, type, kind);
  data->hash = type->serdata_basehash;  // equal for all: there is one instance
  return data;
}

/// Cyclone asks for sizes that are multiples of 4; what is behind the end is 0.
void copy_out(const ddsi_serdata* data, std::size_t offset, std::size_t bytes, void* to) {
  const RawSample& sample = of(data);
  const std::size_t there = offset < sample.size ? std::min(bytes, sample.size - offset) : 0;
  if (there > 0) std::memcpy(to, sample.bytes + offset, there);
  std::memset(static_cast<std::byte*>(to) + there, 0, bytes - there);
}

/// Only the last piece is copied, if its padding would lie outside of the memory.
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

// Nothing is received by these types: they refuse it.
const ddsi_serdata_ops sample_operations = [] {
  ddsi_serdata_ops to{};
  to.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };
  to.get_size = [](const ddsi_serdata* data) { return static_cast<std::uint32_t>(of(data).size); };
  to.from_ser = [](const ddsi_sertype*, ddsi_serdata_kind, const nn_rdata*, std::size_t) -> ddsi_serdata* {
    return nullptr;
  };
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

// Types with one name are equal: no type has a description here.
const ddsi_sertype_ops type_operations = [] {
  ddsi_sertype_ops to{};
  to.version = ddsi_sertype_v0;
  to.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete static_cast<RawType*>(type);
  };
  to.equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; };
  to.hash = [](const ddsi_sertype*) { return 0U; };
  to.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  to.realloc_samples = [](void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {};
  to.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  return to;
}();

}  // namespace

RawTopic raw_topic(dds_entity_t participant, const std::string& name, const std::string& type_name) {
  auto* const made = new RawType{};
  ddsi_sertype_init(made, type_name.c_str(), &type_operations, &sample_operations, true);
  made->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  ddsi_sertype* type = made;
  const dds_entity_t topic =
      dds_create_topic_sertype(participant, name.c_str(), &type, nullptr, nullptr, nullptr);
  if (topic < 0) ddsi_sertype_unref(made);
  return {topic, type};
}

ddsi_serdata* raw_sample(const ddsi_sertype* type, const SampleHandle& sample, std::size_t slots) {
  const detail::SampleState state = state_of(*sample, slots);
  RawSample* const data = make(type, SDK_DATA);
  data->sample = sample;
  data->bytes = state.body - detail::encapsulation_bytes;
  data->size = state.body_bytes + detail::encapsulation_bytes;
  data->readable = static_cast<std::size_t>(sample->data + sample->capacity - data->bytes);
  data->timestamp.v = sample->source_stamp_ns;
  data->statusinfo = 0;
  return data;
}

}  // namespace sft::core
