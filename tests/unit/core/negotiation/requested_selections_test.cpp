// Tests that a selection that many readers request is decoded once.
#include "core/negotiation/requested_selections.h"

#include <string>

#include "core/negotiation/requested_selection.h"
#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

class RequestedSelectionsTest : public NegotiationTest {
 protected:
  Request asking_for(const std::string& text) {
    Request asked = request(7, 1, F::height | F::width);
    const Selection wanted = type.parse_selection(text).value();
    asked.mask_words = wanted.mask().to_words();
    if (!wanted.is_mask()) asked.parts = wanted.to_bytes();
    return asked;
  }
  Selection of(EndpointId reader, const Request& request) {
    return selections.of({100, reader}, request, type).value();
  }

  RequestedSelections selections;
};

TEST_F(RequestedSelectionsTest, AreDecodedAnewOnlyWhereTheyHaveChanged) {
  const Request window = asking_for("height, data[1:100]"), moved = asking_for("height, data[2:100]");
  for (int round = 0; round < 3; ++round) {
    for (EndpointId reader = 1; reader <= 64; ++reader)
      ASSERT_EQ(of(reader, window), requested_selection(window, type));
  }
  EXPECT_EQ(selections.decoded(), 64U);
  EXPECT_EQ(of(7, moved), requested_selection(moved, type));
  EXPECT_EQ(of(7, moved), requested_selection(moved, type));
  EXPECT_EQ(selections.decoded(), 65U) << "once";
  const Request fields = asking_for("height, width");
  for (int round = 0; round < 3; ++round) ASSERT_EQ(of(7, fields), requested_selection(fields, type));
  EXPECT_EQ(selections.decoded(), 66U) << "so are masks";
}

TEST_F(RequestedSelectionsTest, WithOtherFieldsAreOthers) {
  const Request narrow = asking_for("data[1:100]");
  Request wide = asking_for("width, data[1:100]");
  wide.parts = narrow.parts;
  EXPECT_EQ(of(7, narrow).mask(), requested_selection(narrow, type)->mask());
  EXPECT_EQ(of(7, wide).mask(), requested_selection(wide, type)->mask());
}

TEST_F(RequestedSelectionsTest, OfWholeFieldsTakeTheirPlace) {
  const Request window = asking_for("data[1:100]"), fields = asking_for("height, width");
  (void)of(7, window);
  EXPECT_EQ(of(7, fields), Selection(FieldMask(F::height | F::width)));
  EXPECT_EQ(of(7, window), requested_selection(window, type));
  EXPECT_EQ(selections.decoded(), 3U);
}

TEST_F(RequestedSelectionsTest, OfOneThatIsGoneAreForgotten) {
  const Request window = asking_for("data[1:100]");
  (void)of(7, window);
  (void)of(8, window);
  selections.forget(7);
  (void)of(7, window);
  (void)of(8, window);
  EXPECT_EQ(selections.decoded(), 3U);
  selections.forget(100);
  (void)of(8, window);
  EXPECT_EQ(selections.decoded(), 4U) << "the writer";
}

TEST_F(RequestedSelectionsTest, ThatAreMalformedAreRefusedEachTime) {
  Request request = asking_for("data[1:100]");
  request.parts.resize(3);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(selections.of({100, 7}, request, type));
  EXPECT_EQ(selections.decoded(), 1U);
}

}  // namespace
}  // namespace sft::core
