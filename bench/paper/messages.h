// The messages that all contenders send, as a message of SFT and as the CDR of the same message.
#pragma once

#include <sft/sft.h>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bench/paper/configuration.h"
#include "bench/paper/contender.h"

namespace sft::bench::paper {

/// Some messages of one type, which are sent in turns. Immutable.
class Messages {
 public:
  virtual ~Messages() = default;

  virtual const TypeSupport& type() const = 0;
  /// Opens a publisher of these messages.
  virtual std::unique_ptr<Writer> publisher(Node& node, const std::string& topic,
                                            const PublisherOptions& options) const = 0;
  /// The bytes of CDR of a message, by its number, if only these fields are sent.
  virtual std::size_t masked_bytes(std::size_t number, FieldSet fields) const = 0;

  /// The bodies of the messages in CDR, without encapsulation, with all fields.
  const std::vector<std::vector<std::byte>>& bodies() const { return bodies_; }
  std::size_t size() const { return bodies_.size(); }

  FieldSet all() const { return all_fields(type().type().members.size()); }
  /// The fields as a mask, and as Node::subscriber() takes them.
  FieldMask mask_of(FieldSet fields) const;
  std::string text_of(FieldSet fields) const { return type().format_mask(mask_of(fields)); }
  /// The fields with these names.
  FieldSet named(const std::vector<std::string>& names) const;

 protected:
  std::vector<std::vector<std::byte>> bodies_;
};

using SharedMessages = std::shared_ptr<const Messages>;

/// Messages of the parametric study. REQUIRES: the paper has them.
SharedMessages parametric_messages(std::size_t fields, std::size_t field_bytes);
/// 360 ranges and as many intensities.
SharedMessages laser_scans();
SharedMessages battery_states();
/// 100 x 100 cells.
SharedMessages occupancy_grids();
/// 16 kB of points.
SharedMessages point_clouds();

// Messages that others recorded, from files below `data`; null if these are not there.

/// Scans of a robot's laser, 361 ranges and as many intensities.
SharedMessages recorded_laser_scans(const std::filesystem::path& data);
SharedMessages recorded_battery_states(const std::filesystem::path& data);
/// The map of a building.
SharedMessages recorded_occupancy_grids(const std::filesystem::path& data);
/// The first points of a rotating lidar's cloud, 16 kB of them.
SharedMessages recorded_point_clouds(const std::filesystem::path& data);

}  // namespace sft::bench::paper
