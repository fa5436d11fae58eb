// The doorbells of programs that start while /dev/shm is full. Other programs of the same account can ring
// these doorbells nevertheless, so shared memory can be used as soon as there is space.
#include <fcntl.h>
#include <unistd.h>

#include <string>

#include "core/platform/doorbell.h"
#include "shm_transport/wake/doorbell_pages.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::DoorbellPage;

class FullMemory : public ShmTest {
 protected:
  FullMemory() : ShmTest(1) {}
  void SetUp() override {
    ShmTest::SetUp();
    if (IsSkipped()) return;
    const int file = open("/dev/shm/full", O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    const std::string block(4096, 'x');
    while (write(file, block.data(), block.size()) > 0) continue;
    close(file);
  }
};

TEST_F(FullMemory, LeavesADoorbellWithoutAPathThatOthersOfTheAccountRing) {
  const auto page = DoorbellPage::create();
  ASSERT_NE(page->id(), 0U);
  EXPECT_NE(access(DoorbellPage::path_of(page->id()).c_str(), F_OK), 0);
  EXPECT_FALSE(DoorbellPage::open(page->id()));
  shm::DoorbellPages pages;
  const core::Route route{.reader = 7, .destination = core::DoorbellAddress{page->id(), 5}, .selection = {}};
  const auto opened = pages.page_of(route, {});
  ASSERT_TRUE(opened) << opened.error().message;
  (*opened)->at(5).ring();
  EXPECT_EQ(page->at(5).rings.load(), 1U);
}

TEST_F(FullMemory, HasNoDoorbellsOfEndedPrograms) {
  std::uint64_t id = 0;
  id = DoorbellPage::create()->id();
  EXPECT_FALSE(DoorbellPage::nameless_pages().contains(id));
}

}  // namespace
}  // namespace sft::test
