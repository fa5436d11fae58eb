// In steady state, sending a sample to many readers and taking it allocate no memory. This holds if the
// writer serves all readers in shared memory, and if it serves only some.
#include "tests/support/thread_allocations.h"
#include "tests/transports/shm/many_readers.h"

namespace sft::test {
namespace {

class ManyReadersAllocations : public ManyReaders {
 protected:
  /// Returns the number of allocations of this thread for 200 samples, after 50 samples of warming up. All
  /// readers that get a sample take it.
  std::uint64_t allocations() {
    for (int i = 0; i < 50; ++i) exchange();
    taken_ = 0;
    const std::uint64_t before = thread_allocations();
    for (std::size_t i = 0; i < samples; ++i) exchange();
    return thread_allocations() - before;
  }
  void exchange() {
    if (gate_ != nullptr) {
      gate_->consider(detail::FieldSource::of_nothing(), ++stamp_ns_);
      gate_->made(detail::FieldSource::of_nothing(), stamp_ns_);
    }
    writer_->send_frame();
    for (const auto& reader : readers_)
      while (reader->take()) ++taken_;
  }

  static constexpr std::size_t samples = 200;
  std::shared_ptr<core::Gate> gate_;
  std::int64_t stamp_ns_ = 0;
  std::size_t taken_ = 0;
};

TEST_F(ManyReadersAllocations, AreNoneWhereAllReadersAreServed) {
  serve_all_but({});
  EXPECT_EQ(allocations(), 0U);
  EXPECT_EQ(taken_, samples * readers);
}

TEST_F(ManyReadersAllocations, AreNoneWhereSomeReadersAreNotServed) {
  for (const std::vector<std::size_t>& unserved : {std::vector<std::size_t>{20}, {0, 1, 2, 30, 31, 62, 63}}) {
    serve_all_but(unserved);
    EXPECT_EQ(allocations(), 0U);
    EXPECT_EQ(taken_, samples * (readers - unserved.size()));
  }
}

TEST_F(ManyReadersAllocations, AreNoneWhereSomeReadersHaveConditionsAndOthersAreNotServed) {
  gate_ = gate("every 2nd");
  Services services(readers);
  for (std::size_t i = 0; i < readers; ++i)
    services[i] = {.is_served = i % 4 != 0, .gate = i % 2 == 1 ? gate_ : nullptr};
  serve(services);
  gate_->reader_begins();
  EXPECT_EQ(allocations(), 0U);
  EXPECT_EQ(taken_, samples * readers / 4 + samples / 2 * readers / 2);
}

}  // namespace
}  // namespace sft::test
