// Computes the bytes of a recording by topic and field, and the bytes that selections would have sent
// instead.
//
// Recorded samples are processed as publishers process live samples, with the same projections, parts and
// conditions. The bytes are those of bodies, as in the status of publishers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sft/detail/conditions.h"
#include "sft/detail/project.h"
#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft::recording {

/// The samples of one topic with one type.
class TopicEstimate {
 public:
  struct Field {
    std::string path;         ///< "header.stamp.sec"; all elements of a sequence count as one field
    std::uint64_t bytes = 0;  ///< the bytes of the field, including padding
  };

  /// `selection` may be null: then all fields are selected.
  TopicEstimate(DynamicType type, const Selection* selection);

  /// Counts a message with its encapsulation. Returns an error if the message does not fit the type. Such a
  /// message is not counted.
  Result<void> add(std::span<const std::byte> cdr, std::uint64_t log_ns);

  std::uint64_t samples() const { return samples_; }
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t selected_samples() const { return selected_samples_; }
  std::uint64_t selected_bytes() const { return selected_bytes_; }
  /// Returns the fields by size, the largest first.
  std::vector<Field> fields() const;
  const DynamicType& type() const { return type_; }

 private:
  void measure(const detail::SampleState& state, const StructType& type, std::size_t leaf,
               std::uint64_t offset, const std::string& prefix);
  bool passes(const detail::SampleState& state, std::int64_t stamp_ns);

  DynamicType type_;
  FieldMask full_;
  std::optional<Selection> selection_{};
  std::optional<detail::ProjectionPlan> plan_{};
  detail::Conditions conditions_{};
  detail::Projection projection_{};
  std::vector<std::uint64_t> body_{};  ///< memory for a body, aligned to 8
  std::vector<std::uint32_t> index_{};
  std::map<std::string, std::uint64_t> fields_{};
  std::uint64_t samples_ = 0, bytes_ = 0;
  std::uint64_t selected_samples_ = 0, selected_bytes_ = 0;
  std::optional<std::int64_t> slot_{};  ///< the period of the maximum rate in which the last sample passed
};

}  // namespace sft::recording
