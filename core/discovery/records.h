// Records: the endpoints, requests and inquiries of a process. A record consists of a key, a revision, and
// bytes. Each process owns its records. Other processes hold copies, which they compare with the owner's by
// a digest. Uses no clock, thread or I/O.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

using LinkId = std::uint32_t;  ///< a link that is made anew gets a greater id

/// A random number for each start of a process, never 0.
using ProcessId = std::uint64_t;

/// The id that Cyclone gives a DDS participant.
using ParticipantGuid = std::array<std::uint8_t, 16>;

/// A participant of another process as one of our links sees it. A process has one participant on each of
/// its links.
struct RemoteParticipant {
  LinkId link = 0;
  ParticipantGuid guid{};
  friend auto operator<=>(const RemoteParticipant&, const RemoteParticipant&) = default;
};

/// Holds a value for each role.
template <class Value>
struct PerRole {
  Value writer{}, reader{};
  Value& operator[](Role role) { return role == Role::writer ? writer : reader; }
  const Value& operator[](Role role) const { return role == Role::writer ? writer : reader; }
  friend bool operator==(const PerRole&, const PerRole&) = default;
};
inline constexpr std::array both_roles{Role::writer, Role::reader};

enum class RecordKind : std::uint8_t {
  announcement,  ///< the record announces an endpoint
  request,       ///< the record contains the request of a subscriber
  inquiry        ///< a topic for which the process wants reports on progress or accounts
};

/// A slot is a number within its process. A slot belongs to one endpoint or inquiry. Once its owner is
/// withdrawn, another owner gets the slot, because Cyclone keeps some 2 kB for each key that was ever
/// written.
struct RecordKey {
  std::uint32_t slot = 0;
  RecordKind kind{};
  friend auto operator<=>(const RecordKey&, const RecordKey&) = default;
};

using RecordBody = std::shared_ptr<const std::vector<std::byte>>;

struct Record {
  std::uint64_t revision = 0;  ///< the number of the change in its process; of two records with one key, the
                               ///< greater revision is in force
  RecordBody body{};           ///< null: the record was withdrawn
  bool is_withdrawn() const { return body == nullptr; }
  std::size_t bytes() const { return is_withdrawn() ? 0 : body->size(); }
  friend bool operator==(const Record& a, const Record& b);
};

/// The records of one role of one process, and their digest.
class Records {
 public:
  /// Enters a record. It replaces the record with the same key, if there is one.
  void put(const RecordKey& key, Record record);
  void erase(const RecordKey& key);
  /// Returns the record; null if there is no record with that key.
  const Record* find(const RecordKey& key) const;
  const std::map<RecordKey, Record>& all() const { return all_; }
  std::size_t bytes() const { return bytes_; }  ///< the size of all bodies in bytes

  /// Returns a number that is the same for equal records, in whichever order they came; 0 if there are no
  /// records. Withdrawn records are included, so that a lost withdrawal is detected.
  std::uint64_t digest() const { return digest_; }

 private:
  std::map<RecordKey, Record> all_;
  std::uint64_t digest_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace sft::core
