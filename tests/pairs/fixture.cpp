#include "tests/pairs/fixture.h"

#include <algorithm>

#include "tests/support/isolated_host.h"

namespace sft::test {

using testing::AssertionFailure;
using testing::AssertionResult;
using testing::AssertionSuccess;

namespace {

json entry_of(const json& entries, const char* key, const json& value) {
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const json& e) { return e[key] == value; });
  return found == entries.end() ? json() : *found;
}

json writer_in(const json& status, const Peer& publisher) {
  return entry_of(status["subscriber"]["writers"], "node", publisher.name());
}

json taken_in(const json& status, const Peer& publisher) {
  const json writer = writer_in(status, publisher);
  return writer.is_null() ? json() : entry_of(status["taken"], "writer", writer["id"]);
}

}  // namespace

json with_short_lease(json options) {
  options["cyclonedds"] = "<CycloneDDS><Domain><Discovery><LeaseDuration>" +
                          std::to_string(short_lease.count()) +
                          " ms</LeaseDuration></Discovery></Domain></CycloneDDS>";
  return options;
}

void NegotiationTest::SetUp() {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  if (const std::string refusal = Network::refusal(); !refusal.empty()) GTEST_SKIP() << refusal;
  network_.emplace(random());
  here_.emplace(*network_);
  there_.emplace(*network_);
}

json reader_of(Peer& publisher, const Peer& subscriber) {
  return entry_of(publisher.status()["publisher"]["readers"], "node", subscriber.name());
}

json writer_of(const Peer& publisher, Peer& subscriber) { return writer_in(subscriber.status(), publisher); }

json taken_of(const Peer& publisher, Peer& subscriber) { return taken_in(subscriber.status(), publisher); }

bool is_served(Peer& publisher, const Peer& subscriber) {
  const json reader = reader_of(publisher, subscriber);
  return !reader.is_null() && reader["served"];
}

bool is_served_by(Peer& publisher, const Peer& subscriber, const std::string& transport) {
  const json reader = reader_of(publisher, subscriber);
  return !reader.is_null() && reader["served"] && reader["transport"] == transport;
}

bool is_served_with(Peer& publisher, const Peer& subscriber, const std::string& mask) {
  const json reader = reader_of(publisher, subscriber);
  return !reader.is_null() && reader["served"] && reader["mask"] == mask;
}

AssertionResult agree(Peer& publisher, Peer& subscriber) {
  json reader, ours, writer;
  const bool agreed = comes_true([&] {
    reader = reader_of(publisher, subscriber);
    ours = subscriber.status()["subscriber"];
    writer = writer_of(publisher, subscriber);
    return !reader.is_null() && !writer.is_null() && reader["served"] && writer["matched"] &&
           writer["alive"] && reader["transport"] == writer["transport"] && reader["mask"] == ours["mask"] &&
           reader["request"] == ours["requests"];
  });
  if (agreed) return AssertionSuccess();
  return AssertionFailure() << publisher.name() << " tells " << reader << ", and " << subscriber.name()
                            << " tells " << ours;
}

AssertionResult accounts_for_all(Peer& publisher, Peer& subscriber) {
  json status;
  const bool came = comes_true([&] {
    publisher.publish(1);
    const json published = publisher.status()["publisher"]["published"];
    return comes_true(
        [&] {
          status = subscriber.status();
          const json taken = taken_in(status, publisher);
          return !taken.is_null() && taken["last"] == published &&
                 // The two counts are read one after the other.
                 taken["received"] == writer_in(status, publisher)["received"];
        },
        500ms);
  });
  if (!came) return AssertionFailure() << "nothing comes any more: " << status;
  const json writer = writer_in(status, publisher);
  const json taken = taken_in(status, publisher);
  const auto count = [](const json& of, const char* key) { return of[key].get<std::uint64_t>(); };
  const std::uint64_t expected = count(taken, "last") - count(taken, "first") + 1;
  const std::uint64_t accounted = count(writer, "received") + count(writer, "lost") +
                                  count(writer, "withheld") + count(writer, "expired");
  const bool right = std::ranges::all_of(status["taken"], [&](const json& of_writer) {
    return count(of_writer, "wrong") == 0 && count(of_writer, "disordered") == 0;
  });
  if (right && accounted == expected) return AssertionSuccess();
  return AssertionFailure() << expected << " were published, " << accounted
                            << " are accounted for: " << writer << ", taken: " << status["taken"];
}

bool was_notified(const json& events, const std::string& kind, const std::string& text) {
  return std::any_of(events.begin(), events.end(), [&](const json& event) {
    return event["kind"] == kind && event["text"].get<std::string>().find(text) != std::string::npos;
  });
}

testing::AssertionResult gets_event(Peer& peer, const std::string& side, const std::string& kind,
                                    const std::string& text) {
  if (comes_true([&] { return was_notified(peer.status()[side], kind, text); }))
    return testing::AssertionSuccess();
  return testing::AssertionFailure() << peer.name() << " has got: " << peer.status()[side];
}

}  // namespace sft::test
