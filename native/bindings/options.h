#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "isimp/core/options.h"
#include "made.h"

namespace isimp::bindings {

namespace py = pybind11;
using namespace py::literals;

/// A Python value as an option's type; `name` ("PartitionOptions.proxies") is for the message.
/// \throws InvalidInput  another type than wanted, or out of that type's range
std::int64_t to_integer(py::handle value, const std::string& name, std::int64_t low, std::int64_t high);
std::uint64_t to_unsigned(py::handle value, const std::string& name);
double to_number(py::handle value, const std::string& name);
bool to_bool(py::handle value, const std::string& name);
std::string to_text(py::handle value, const std::string& name);

template <class T>
T to_option(py::handle value, const std::string& name) {
  if constexpr (std::is_same_v<T, bool>)
    return to_bool(value, name);
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return to_unsigned(value, name);
  else if constexpr (std::is_integral_v<T>)
    return static_cast<T>(to_integer(value, name, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
  else if constexpr (std::is_floating_point_v<T>)
    return to_number(value, name);
  else
    return to_text(value, name);
}

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

/// The name of a type in Python and the stubs.
template <class T>
std::string type_name() {
  if constexpr (is_optional<T>)
    return type_name<typename T::value_type>() + " | None";
  else if constexpr (std::is_same_v<T, bool>)
    return "bool";
  else if constexpr (std::is_integral_v<T>)
    return "int";
  else if constexpr (std::is_floating_point_v<T>)
    return "float";
  else
    return "str";
}

/// Warns the caller. Throws where the caller's filters make the warning an error.
void warn(const std::string& text);

/// \throws InvalidInput  the message lists the names
std::size_t to_choice(py::handle value, const std::string& name, const std::vector<std::string>& names);

/// Makes a Python class of a struct of options from the table of its fields: keyword construction, fields that can be
/// read and set, repr, equality, copy and pickle, and the table itself. Defaults are the struct's own.
template <class Options>
class OptionsClass {
 public:
  OptionsClass(py::module_& m, const char* name, const char* doc)
      : name_(name),
        fields_(std::make_shared<Fields>()),
        gone_(std::make_shared<Fields>()),
        class_(m, name, py::module_local(), doc) {
    const Options* none = nullptr;
    std::apply([&](const auto&... all) { (add(all), ...); }, isimp::fields(none));
    if constexpr (requires { isimp::gone_fields(none); })
      for (const Gone& field : isimp::gone_fields(none)) add(field);
    finish();
  }

 private:
  struct Slot {
    std::string name;
    std::function<py::object(const Options&)> get;
    std::function<void(Options&, py::handle, const std::string&)> set;
    std::function<py::dict()> about;
  };
  using Fields = std::vector<Slot>;

  template <class T>
  void add(const Field<Options, T>& f) {
    const auto member = f.member;
    const auto about = [f] {
      py::dict facts("name"_a = f.name, "type"_a = type_name<T>(), "about"_a = f.about);
      if (f.range.low > -std::numeric_limits<double>::infinity()) {
        facts["least"] = f.range.low;
        facts["above_least"] = !f.range.with_low;
      }
      if (f.range.high < std::numeric_limits<double>::infinity()) {
        facts["most"] = f.range.high;
        facts["below_most"] = !f.range.with_high;
      }
      facts["range"] = words(f.range, f.unit);
      facts["unit"] = f.unit == Unit::length ? "length" : "";
      facts["label"] = f.texts.label;
      facts["tip"] = f.texts.tip;
      if (f.slider.low > -std::numeric_limits<double>::infinity()) facts["low"] = f.slider.low;
      if (f.slider.high < std::numeric_limits<double>::infinity()) facts["high"] = f.slider.high;
      facts["digits"] = f.slider.digits;
      return facts;
    };
    if constexpr (is_optional<T>) {
      using Value = typename T::value_type;
      push(
          f.name, f.about,
          [member](const Options& o) {
            return o.*member ? py::object(py::cast(*(o.*member))) : py::object(py::none());
          },
          [member](Options& o, py::handle value, const std::string& full) {
            o.*member = value.is_none() ? std::nullopt : std::optional<Value>(to_option<Value>(value, full));
          },
          about);
    } else {
      push(
          f.name, f.about, [member](const Options& o) -> py::object { return py::cast(o.*member); },
          [member](Options& o, py::handle value, const std::string& full) { o.*member = to_option<T>(value, full); },
          about);
    }
  }

  /// Binds an enumeration. Python reads and sets its values by name.
  template <class Enum, std::size_t N>
  void add(const Choice<Options, Enum, N>& c) {
    std::vector<std::string> names;
    for (const auto& value : c.values) names.emplace_back(value.name);
    const auto about = [c, names] {
      py::list items;
      for (const auto& value : c.values) items.append(py::make_tuple(value.name, value.texts.label, value.texts.tip));
      return py::dict("name"_a = c.name, "type"_a = "str", "about"_a = c.about, "choices"_a = names,
                      "label"_a = c.texts.label, "tip"_a = c.texts.tip, "items"_a = items);
    };
    push(
        c.name, c.about,
        [c](const Options& o) -> py::object {
          for (const auto& value : c.values)
            if (value.value == o.*(c.member)) return py::str(value.name);
          return py::none();
        },
        [c, names](Options& o, py::handle value, const std::string& full) {
          o.*(c.member) = c.values[to_choice(value, full, names)].value;
        },
        about);
  }

  /// Binds a field of earlier versions: another value than the one without effect gives a warning.
  void add(const Gone& field) {
    const std::string full = name_ + "." + field.name;
    const auto get = [field](const Options&) {
      return std::visit([](const auto& value) { return py::object(py::cast(value)); }, field.without);
    };
    const auto set = [get](Options& options, py::handle value, const std::string& name) {
      if (!value.equal(get(options))) warn(name + " has no effect: this version of iSimp does not have it");
    };
    class_.def_property(
        field.name, get, [set, full](Options& options, const py::object& value) { set(options, value, full); },
        "Of earlier versions. It has no effect.");
    gone_->push_back({field.name, get, set, nullptr});
  }

  void finish() {
    const auto fields = fields_, gone = gone_;
    const std::string name = name_;
    const auto make = [fields, gone, name](const py::dict& values) {
      Options options;
      for (const auto& [key, value] : values)
        if (!set(*fields, options, name, key, value) && !set(*gone, options, name, key, value))
          refuse(*fields, name, key);
      return options;
    };
    class_.def(py::init([make](const py::kwargs& values) { return make(values); }))
        .def(
            "as_dict", [fields](const Options& options) { return dict(*fields, options); }, "The fields by name.")
        .def_static(
            "fields",
            [fields] {
              py::list all;
              for (const Slot& field : *fields) {
                py::dict facts = field.about();
                facts["default"] = field.get(Options());
                all.append(facts);
              }
              return all;
            },
            "The table of the fields, in order: dicts of name, type, default and about. Numbers have range (in words), "
            "unit ('length': scene units), and where there is an end, least and above_least (least itself is no "
            "value), most and below_most. A field with a few names as values has choices.")
        .def_static(
            "gone", [gone] { return dict(*gone, Options()); },
            "The options that only earlier versions have: a dict of the name of each and the value that turned it off. "
            "This version accepts and ignores them.")
        .def("__repr__",
             [fields, name](const Options& options) {
               std::string text;
               for (const Slot& field : *fields)
                 text += (text.empty() ? "" : ", ") + field.name + "=" + std::string(py::repr(field.get(options)));
               return name + "(" + text + ")";
             })
        .def("__eq__",
             [fields](const Options& options, const py::object& other) -> py::object {
               if (!py::isinstance<Options>(other)) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
               return py::bool_(dict(*fields, options).equal(dict(*fields, other.cast<const Options&>())));
             })
        .def(py::pickle([fields](const Options& options) { return dict(*fields, options); }, make));
  }

  template <class Get, class Set, class About>
  void push(const char* name, std::string doc, Get get, Set set, About about) {
    const std::string full = name_ + "." + name;
    const py::dict facts = about();
    if (facts.contains("range") && py::len(facts["range"]) > 0)
      doc += " Must be " + facts["range"].template cast<std::string>() + ".";
    class_.def_property(
        name, get, [set, full](Options& options, const py::object& value) { set(options, value, full); }, doc.c_str());
    fields_->push_back({name, get, set, about});
  }

  static py::dict dict(const Fields& fields, const Options& options) {
    py::dict values;
    for (const Slot& field : fields) values[py::str(field.name)] = field.get(options);
    return values;
  }

  /// Sets one of some fields; false if it is none of them.
  static bool set(const Fields& fields, Options& options, const std::string& owner, py::handle name, py::handle value) {
    for (const Slot& field : fields) {
      if (!name.equal(py::str(field.name))) continue;
      field.set(options, value, owner + "." + field.name);
      return true;
    }
    return false;
  }

  [[noreturn]] static void refuse(const Fields& fields, const std::string& owner, py::handle name) {
    std::string known;
    for (const Slot& field : fields) known += (known.empty() ? "" : ", ") + field.name;
    throw py::type_error(owner + " has no field " + std::string(py::repr(name)) + "; its fields are " + known);
  }

  std::string name_;
  std::shared_ptr<Fields> fields_, gone_;
  py::class_<Options> class_;
};

}  // namespace isimp::bindings
