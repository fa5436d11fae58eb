// What is in force of all that was said on a control topic: what a node is told that begins to listen later
// than others of its process. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "core/discovery/control_word.h"
#include "core/discovery/participants.h"

namespace sft::core {

class KeptWords {
 public:
  using Word = std::shared_ptr<const ControlWord>;

  static constexpr std::size_t bytes_max = std::size_t{32} << 20;

  explicit KeptWords(std::size_t at_most = bytes_max) : bytes_max_(at_most) {}

  /// Keeps an announcement or a request, in place of the former one of the same participant. Forgets what
  /// was withdrawn, or is kept alive by nobody.
  void learn(const Word& word);
  void forget(const Participants::Guid& participant);
  void clear();
  /// False if there was more than may be kept; then nothing is kept. Without that bound, somebody who
  /// announces many endpoints could take any amount of memory.
  bool are_complete() const { return are_complete_; }
  /// In an order in which they may be told.
  std::vector<Word> all() const;

 private:
  /// Announcements go first.
  enum class Kind : std::uint8_t { announcement, request };
  using Key = std::tuple<Kind, EndpointId, Participants::Guid>;

  void keep(const Key& key, const Word& word);
  void drop(std::map<Key, Word>::iterator kept);
  void drop_all_of(EndpointId id);

  const std::size_t bytes_max_;
  std::size_t bytes_ = 0;
  bool are_complete_ = true;
  std::map<Key, Word> words_;
  std::map<Participants::Guid, std::size_t> counts_;  ///< of the words of each participant
};

}  // namespace sft::core
