// Compares the offer or the request of an unmodified DDS endpoint with the request or the offer of SFT. DDS
// itself decides if the two match. These functions explain in words why they do not match. They are pure
// functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/seam/address.h"
#include "core/vanilla/participant_entities.h"
#include "sft/qos.h"

namespace sft::core {

/// Returns the user data of an endpoint for unmodified peers. `type_hash` is a result of ros_type_hash(),
/// or empty if the type has no hash. `id` is the id of the publisher or the subscriber. `is_answered` is
/// false if a reader of the publisher does not acknowledge its samples.
std::string endpoint_user_data(std::string_view type_hash, EndpointId id, bool is_answered = true);
/// Returns the hash in the user data of an endpoint of ROS 2, or an empty text if there is none.
std::string_view type_hash_in(std::string_view user_data);
/// Returns the id of the publisher or subscriber of SFT in these user data, or 0 if they contain none.
EndpointId id_in(std::string_view user_data);
/// Returns the value of `is_answered` in the user data of a publisher of SFT.
bool is_answered_in(std::string_view user_data);

/// A reader or a writer as DDS announces it. A duration of 0 means that the policy is not set.
struct VanillaEndpoint {
  EndpointId id = 0;          ///< derived from the GUID
  std::string guid{};         ///< the GUID in hexadecimal
  std::string participant{};  ///< "DDS" and the GUID prefix of its participant in hexadecimal
  std::string type_name{};
  std::string type_hash{};                ///< empty: the endpoint announces no hash
  Qos qos{};                              ///< the policies of the endpoint that SFT has, too
  std::vector<std::string> partitions{};  ///< empty: the endpoint is in the default partition
  bool has_xcdr1 = true;  ///< true: the endpoint accepts or sends XCDR1, the encoding of SFT's samples
  bool is_keyed = false;
  bool owns_exclusively = false;
  Guid key{};          ///< the GUID in the form of DDS
  std::string node{};  ///< the name of the endpoint's node in ROS 2; empty if unknown
};

/// Returns the QoS that a publisher offers to unmodified readers. The publisher is reliable for readers
/// that request reliability, and retains its samples for them. Its liveliness is automatic, without a
/// lease.
Qos offered_to_vanilla(const Qos& publisher);
/// Returns the QoS that a subscriber requests from unmodified writers. DDS sends retained samples only to
/// reliable readers. So a subscriber that requests retained samples requests reliability, too.
Qos requested_from_vanilla(const Qos& subscriber);

// The following functions return all conflicts in words, or an empty text if there is none. `type_name` is
// the name in DDS.

/// Returns a text that says that both sides announce hashes of their types, and that these hashes differ.
/// `ours` is "publisher" or "subscriber".
std::string difference_of_hashes(std::string_view type_hash, const std::string& ours,
                                 const VanillaEndpoint& theirs);
std::string why_not_served(std::string_view type_name, const Qos& offered, const VanillaEndpoint& reader);
/// `type_hash` is the hash of the subscriber's type. Hashes are compared only if both sides have one.
std::string why_not_heard(std::string_view type_name, std::string_view type_hash, const Qos& requested,
                          const VanillaEndpoint& writer);

}  // namespace sft::core
