#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>

#include "isimp/core/errors.h"

/// The table of options: name, range and meaning of each field of a struct of options, written once. Checks, the Python
/// classes, their stubs, the flags of the command, and the add-on's settings with their labels follow from it.
///
/// Each struct has a function `constexpr auto fields(const Options*)` below it. It returns a tuple of Field and Choice,
/// one for each member, in order. Defaults are the struct's own.
namespace isimp {

/// The numbers that a field accepts: an interval, with or without each end. It contains infinity only if `infinite`.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool with_low = true, with_high = true, infinite = false;

  [[nodiscard]] constexpr bool holds(double x) const {
    return (with_low ? x >= low : x > low) && (with_high ? x <= high : x < high) &&
           (infinite || (x > -std::numeric_limits<double>::infinity() && x < std::numeric_limits<double>::infinity()));
  }
};

constexpr Range between(double low, double high) { return {.low = low, .high = high}; }
constexpr Range above_to(double low, double high) { return {.low = low, .high = high, .with_low = false}; }
constexpr Range from_below(double low, double high) { return {.low = low, .high = high, .with_high = false}; }
constexpr Range at_least(double low) { return {.low = low}; }
constexpr Range above(double low) { return {.low = low, .with_low = false}; }
constexpr Range at_least_or_infinite(double low) { return {.low = low, .infinite = true}; }
constexpr Range any() { return {.infinite = true}; }

enum class Unit {
  none,    ///< a count, a factor, a share
  length,  ///< scene units
};

/// The add-on's texts of a field: a field without a label is a setting of recipes, but not of the panel.
struct Shown {
  const char* label = "";
  const char* tip = "";
};

/// The range of the add-on's slider, inside the range of the field.
struct Slider {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::int32_t digits = 0;  ///< after the point; 0: as usual
};

/// One member of a struct of options; T may be a std::optional.
template <class Options, class T>
struct Field {
  const char* name;
  T Options::*member;
  Range range;
  Unit unit;
  const char* about;  ///< one or a few sentences
  Shown texts = {};
  Slider slider = {};

  /// The field with a label and a tooltip, so that the add-on shows it.
  [[nodiscard]] constexpr Field shown(const char* label, const char* tip, const Slider& range_shown = {}) const {
    return {name, member, range, unit, about, {label, tip}, range_shown};
  }
};

template <class Enum>
struct NamedValue {
  const char* name;
  Enum value;
  Shown texts = {};
};

/// The name of a value, which must be in the table.
template <class Enum, std::size_t N>
constexpr const char* name_of(const NamedValue<Enum> (&values)[N], Enum value) {
  std::size_t i = 0;
  while (values[i].value != value) ++i;
  return values[i].name;
}

/// A member that is an enumeration, with the names of its values.
template <class Options, class Enum, std::size_t N>
struct Choice {
  const char* name;
  Enum Options::*member;
  std::array<NamedValue<Enum>, N> values;
  const char* about;
  Shown texts = {};

  /// The field with a label and a tooltip, so that the add-on shows it.
  [[nodiscard]] constexpr Choice shown(const char* label, const char* tip) const {
    return {name, member, values, about, {label, tip}};
  }
};

template <class Options, class T>
constexpr Field<Options, T> field(const char* name, T Options::*member, Range range, Unit unit, const char* about) {
  return {name, member, range, unit, about};
}
/// A member that is no number: a switch, a name.
template <class Options, class T>
constexpr Field<Options, T> field(const char* name, T Options::*member, const char* about) {
  return {name, member, any(), Unit::none, about};
}
template <class Options, class Enum, std::size_t N>
constexpr Choice<Options, Enum, N> choice(const char* name, Enum Options::*member, const NamedValue<Enum> (&values)[N],
                                          const char* about) {
  return {name, member, std::to_array(values), about};
}
/// A field of earlier versions whose feature this one lacks. Python accepts it and warns, so scripts still run. A struct
/// with such fields has a function `constexpr auto gone_fields(const Options*)` that returns an array of them.
struct Gone {
  const char* name;
  std::variant<bool, double, const char*> without;  ///< the value that had no effect
};

/// The field `threads`, which all structs have.
template <class Options>
constexpr auto threads_field(std::int32_t Options::*member) {
  return field("threads", member, at_least(0), Unit::none,
               "Number of threads, at most 256. 0: one for each core. The result does not depend on it.");
}

/// "in [0, 1)", "at least 1", "a finite length above 0"; "" without ends.
inline std::string words(const Range& range, Unit unit) {
  const double infinity = std::numeric_limits<double>::infinity();
  std::ostringstream text;
  text.precision(17);
  const bool length = unit == Unit::length;
  if (range.high < infinity) {
    text << "in " << (range.with_low ? '[' : '(') << range.low << ", " << range.high << (range.with_high ? ']' : ')');
  } else if (range.low > -infinity) {
    if (length) text << (range.infinite ? "a length" : "a finite length") << (range.with_low ? ", " : " ");
    text << (range.with_low ? "at least " : "above ") << range.low;
  }
  return text.str();
}

/// \throws InvalidInput  a number out of the range of its field: "leave_out must be in [0, 1), got 2"
template <class Options, class T>
void check_field(const Options& options, const Field<Options, T>& field) {
  const auto check = [&](const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      if (field.range.holds(static_cast<double>(value))) return;
      std::ostringstream text;
      text << field.name << " must be " << words(field.range, field.unit) << ", got " << value;
      throw InvalidInput(text.str());
    }
  };
  if constexpr (requires { (options.*field.member).has_value(); }) {
    if (options.*field.member) check(*(options.*field.member));
  } else {
    check(options.*field.member);
  }
}
template <class Options, class Enum, std::size_t N>
void check_field(const Options&, const Choice<Options, Enum, N>&) {}

/// \throws InvalidInput  the first field that is out of its range
template <class Options>
void check_fields(const Options& options) {
  std::apply([&](const auto&... all) { (check_field(options, all), ...); }, fields(&options));
}

}  // namespace isimp
