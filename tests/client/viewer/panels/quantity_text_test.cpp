// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/quantity_text.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(QuantityText, HasThreeDigitsAndShortPrefix) {
  EXPECT_EQ(quantity_text(1e4, Unit::Pascal), "10 kPa");
  EXPECT_EQ(quantity_text(0.35, Unit::Kilogram), "0.35 kg");
  EXPECT_EQ(quantity_text(0.0853, Unit::Kilogram), "85.3 g");
  EXPECT_EQ(quantity_text(0.00002, Unit::Kilogram), "20 mg");
  EXPECT_EQ(quantity_text(999.96, Unit::Pascal), "1 kPa");  // rounded before the prefix is chosen
  EXPECT_EQ(quantity_text(7.03e10, Unit::Pascal), "70.3 GPa");
  EXPECT_EQ(quantity_text(0.658, Unit::NewtonSecond), "0.658 N s");
  EXPECT_EQ(quantity_text(0.05, Unit::Newton), "50 mN");
  EXPECT_EQ(quantity_text(1234, Unit::None), "1230");
  EXPECT_EQ(quantity_text(0, Unit::Newton), "0 N");
  EXPECT_EQ(quantity_text(-12.5, Unit::Newton), "-12.5 N");
  EXPECT_EQ(quantity_text(std::nan(""), Unit::Newton), "unknown");
}

TEST(QuantityText, RangeWritesSharedUnitOnce) {
  EXPECT_EQ(range_text(5e3, 2e4, Unit::Pascal), "5 to 20 kPa");
  EXPECT_EQ(range_text(500, 2e4, Unit::Pascal), "500 Pa to 20 kPa");
  EXPECT_EQ(range_text(0, 0.2, Unit::None), "0 to 0.2");
}

TEST(QuantityText, ParsesInputInItsUnit) {
  EXPECT_DOUBLE_EQ(parse_quantity("10 kPa", Unit::Pascal).value(), 1e4);
  EXPECT_DOUBLE_EQ(parse_quantity(" 85g ", Unit::Kilogram).value(), 0.085);
  EXPECT_DOUBLE_EQ(parse_quantity("1e5", Unit::Pascal).value(), 1e5);
  EXPECT_DOUBLE_EQ(parse_quantity("0.5", Unit::None).value(), 0.5);
  for (const char* bad : {"", "soft", "10 kg", "1e999", "nan", "3 kPa kPa"}) {
    const auto value = parse_quantity(bad, Unit::Pascal);
    ASSERT_FALSE(value) << bad;
    EXPECT_NE(value.error().message.find("kPa, MPa, GPa"), std::string::npos) << value.error().message;
  }
}

// Displayed text can be entered again.
TEST(QuantityText, RoundTripsThreeDigits) {
  for (double value = 1.234e-5; value < 1e10; value *= 7.3) {
    for (const Unit unit :
         {Unit::Kilogram, Unit::Pascal, Unit::Newton, Unit::NewtonSecond, Unit::Second, Unit::None}) {
      const auto back = parse_quantity(quantity_text(value, unit), unit);
      ASSERT_TRUE(back) << quantity_text(value, unit);
      EXPECT_NEAR(*back, value, 0.005 * value) << quantity_text(value, unit);  // half of the third digit
    }
  }
}

}  // namespace
}  // namespace livegs
