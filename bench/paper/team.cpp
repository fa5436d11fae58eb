#include "bench/paper/team.h"

#include <unistd.h>

#include <algorithm>

#include "bench/common/pair.h"

namespace sft::bench::paper {

namespace {

constexpr std::int64_t poll_us = 10'000;

/// Opens the contender with its default settings, apart from multicast. The emulated hosts have separate
/// networks, but share one memory. SFT must not look for samples there.
std::unique_ptr<Peer> open(const Contender& contender) {
  if (contender.is_sft()) return contender.multicast ? sft_usual_peer() : sft_unicast_peer();
  if (contender.way == Way::cyclone)
    return contender.multicast ? cyclone_usual_peer() : cyclone_unicast_peer();
  return contender.multicast ? fast_dds_multicast_peer() : fast_dds_usual_peer();
}

/// Returns the request of a reader that needs the fields `needed`.
Wanted wanted(Way way, const Messages& messages, FieldSet needed) {
  const FieldSet read = way == Way::sft_full ? messages.all() : needed;
  return {.fields = messages.text_of(read), .recorded = way == Way::sft_recorded, .read = read};
}

[[noreturn]] void stay() {
  for (;;) pause();
}

double both(const LinkBytes& bytes) { return static_cast<double>(bytes.received + bytes.sent); }

}  // namespace

Used Used::operator-(const Used& before) const {
  Used since{s - before.s, sender_bytes - before.sender_bytes, receiver_bytes, cpu_s - before.cpu_s};
  for (std::size_t i = 0; i < receivers_max; ++i) since.receiver_bytes[i] -= before.receiver_bytes[i];
  return since;
}

Team::Team(const Contender& contender, std::shared_ptr<const hosts::EmulatedNetwork> network,
           const Task& task, std::size_t slot)
    : contender_(contender), task_(task), slot_(slot), processes_(std::move(network), task.receivers) {
  processes_.start(0, [&] { return write_all(); });
  for (std::size_t i = 0; i < task.receivers; ++i) processes_.start(1 + i, [&] { return read_all(i); });
}

Topic Team::topic_of(std::size_t phase) const {
  return {.name = "phase" + std::to_string(phase),
          .messages = task_.phases[phase].messages,
          .reliable = contender_.reliable};
}

int Team::write_all() const {
  const auto peer = open(contender_);
  std::vector<std::unique_ptr<Writer>> writers;
  for (std::size_t i = 0; i < task_.phases.size(); ++i) writers.push_back(peer->writer(topic_of(i)));
  while (!std::ranges::all_of(writers, [&](const auto& writer) { return writer->serves(task_.receivers); }))
    sleep_us(poll_us);
  ++board_->ready;
  if (is_silent()) stay();
  while (board_->begin_ns.load() == 0) sleep_us(poll_us);
  const Schedule schedule(task_.pace, task_.slots, board_->begin_ns.load());
  for (std::size_t i = 0; i < task_.pace.learning; ++i) {
    sleep_until(schedule.learning_ns(i, slot_));
    for (const auto& writer : writers) writer->write(0);
  }
  for (std::size_t i = 0; i < writers.size(); ++i) write_phase(i, *writers[i], schedule);
  stay();
}

void Team::write_phase(std::size_t phase, Writer& writer, const Schedule& schedule) const {
  const Pace& pace = task_.pace;
  const std::size_t messages = task_.phases[phase].messages->size();
  std::int64_t sent_ns = 0;
  for (std::size_t i = 0; i < pace.settling + pace.samples; ++i) {
    const std::int64_t due_ns = schedule.due_ns(phase, i, slot_);
    sleep_until(std::max(due_ns, sent_ns + schedule.pause_min_ns()));
    sent_ns = now_ns();
    if (i >= pace.settling) {
      board_->due_ns[phase][i - pace.settling] = due_ns;
      board_->sent_ns[phase][i - pace.settling] = sent_ns;
    }
    board_->written[phase] = i + 1;
    writer.write(i % messages);
  }
}

int Team::read_all(std::size_t receiver) const {
  const auto peer = open(contender_);
  std::vector<std::unique_ptr<Reader>> readers;
  for (std::size_t i = 0; i < task_.phases.size(); ++i) {
    Topic topic = topic_of(i);
    topic.wanted = wanted(contender_.way, *topic.messages, task_.phases[i].needed[receiver]);
    readers.push_back(peer->reader(topic, note_arrivals(i, receiver)));
  }
  while (!std::ranges::all_of(readers, [](const auto& reader) { return reader->writers() == 1; }))
    sleep_us(poll_us);
  ++board_->ready;
  stay();
}

/// An arriving message counts as the last one that was written. That is correct because the next one is
/// written a period later.
Arrived Team::note_arrivals(std::size_t phase, std::size_t receiver) const {
  return [this, phase, receiver](std::uint64_t) {
    const std::int64_t now = now_ns();
    const std::size_t written = board_->written[phase].load();
    if (written <= task_.pace.settling) return;
    std::int64_t& at = board_->received_ns[phase][receiver][written - task_.pace.settling - 1];
    if (at == 0) at = now;
  };
}

Used Team::used() const {
  Used used{.s = static_cast<double>(now_ns()) / 1e9,
            .sender_bytes = both(processes_.link_bytes(0)),
            .cpu_s = processes_.cpu_s()};
  for (std::size_t i = 0; i < task_.receivers; ++i)
    used.receiver_bytes[i] = both(processes_.link_bytes(1 + i));
  return used;
}

}  // namespace sft::bench::paper
