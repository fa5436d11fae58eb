// expect: set[(][)] takes a value of the field's own type
#include "tests/compile_fail/cloud.h"

enum class Size { small };
template <>
struct sft::detail::EnumTable<Size> {
  static constexpr EnumType type{"Size", false, {}};
};

void misuse(sft::Loan<PointCloud2>& loan) { loan.set(F::width, Size::small); }
