// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/usd/estimate_attributes.h"

#include <google/protobuf/descriptor.h>

#include <cmath>

#include "export/model/message_text.h"

namespace livegs {
namespace {

using google::protobuf::FieldDescriptor;

constexpr std::string_view kEstimate = "livegs:estimate:";

}  // namespace

void write_estimates(const v1::PhysicalParameters& estimates, UsdaText& out) {
  const auto* reflection = v1::PhysicalParameters::GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(estimates, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string name = std::string(kEstimate) + field->name();
    const auto add = [&](const std::string& type, const std::string& value) {
      out.line("custom " + type + " " + name + " = " + value);
    };
    if (field->is_repeated()) {
      std::string list;
      const bool messages = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
      for (int i = 0; i < reflection->FieldSize(estimates, field); ++i) {
        list += i > 0 ? ", " : "";
        list += messages ? usda_string(message_text(reflection->GetRepeatedMessage(estimates, field, i)))
                         : usda_number(reflection->GetRepeatedDouble(estimates, field, i));
      }
      add(messages ? "string[]" : "double[]", "[" + list + "]");
      continue;
    }
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_STRING:
        add("string", usda_string(reflection->GetString(estimates, field)));
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        add("double", usda_number(reflection->GetDouble(estimates, field)));
        break;
      case FieldDescriptor::CPPTYPE_BOOL:
        add("bool", reflection->GetBool(estimates, field) ? "1" : "0");
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        add("uint", std::to_string(reflection->GetUInt32(estimates, field)));
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        add("token", usda_string(reflection->GetEnum(estimates, field)->name()));
        break;
      default: {
        v1::EstimatedValue value;
        value.CopyFrom(reflection->GetMessage(estimates, field));
        add("double3", usda_tuple(Eigen::Vector3d(value.low(), value.best(), value.high())));
        out.line("custom token " + name +
                 ":source = " + usda_string(v1::EstimatedValue::Source_Name(value.source())));
        if (!value.reason().empty())
          out.line("custom string " + name + ":reason = " + usda_string(value.reason()));
      }
    }
  }
}

Result<v1::PhysicalParameters> read_estimates(const UsdaPrim& prim) {
  v1::PhysicalParameters estimates;
  const auto* descriptor = v1::PhysicalParameters::GetDescriptor();
  const auto* reflection = v1::PhysicalParameters::GetReflection();
  for (int i = 0; i < descriptor->field_count(); ++i) {
    const FieldDescriptor* field = descriptor->field(i);
    const std::string name = std::string(kEstimate) + field->name();
    const UsdaValue* value = prim.value(name);
    if (!value) continue;
    const Error bad = invalid_data(prim.path + ": " + name + " has no valid value");
    if (field->is_repeated()) {
      for (const double number : value->numbers) {
        if (field->cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) return bad;
        reflection->AddDouble(&estimates, field, number);
      }
      for (const std::string& text : value->texts) {
        if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
            !read_message_text(text, *reflection->AddMessage(&estimates, field)))
          return bad;
      }
      continue;
    }
    const bool one_number = value->numbers.size() == 1, one_text = value->texts.size() == 1;
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_STRING:
        if (!one_text) return bad;
        reflection->SetString(&estimates, field, value->texts[0]);
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        if (!one_number) return bad;
        reflection->SetDouble(&estimates, field, value->numbers[0]);
        break;
      case FieldDescriptor::CPPTYPE_BOOL:
        if (!one_number) return bad;
        reflection->SetBool(&estimates, field, value->numbers[0] != 0);
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        if (!one_number || !(value->numbers[0] >= 0 && value->numbers[0] <= 4294967295.0)) return bad;
        reflection->SetUInt32(&estimates, field, static_cast<uint32_t>(value->numbers[0]));
        break;
      case FieldDescriptor::CPPTYPE_ENUM: {
        const auto* word = one_text ? field->enum_type()->FindValueByName(value->texts[0]) : nullptr;
        if (!word) return bad;
        reflection->SetEnum(&estimates, field, word);
        break;
      }
      default: {
        if (value->numbers.size() != 3) return bad;
        v1::EstimatedValue estimated;
        estimated.set_low(value->numbers[0]);
        estimated.set_best(value->numbers[1]);
        estimated.set_high(value->numbers[2]);
        const std::string source_word = prim.text(name + ":source");
        v1::EstimatedValue::Source source = v1::EstimatedValue::SOURCE_UNKNOWN;
        if (!source_word.empty() && !v1::EstimatedValue::Source_Parse(source_word, &source)) return bad;
        estimated.set_source(source);
        estimated.set_reason(prim.text(name + ":reason"));
        reflection->MutableMessage(&estimates, field)->CopyFrom(estimated);
      }
    }
  }
  return estimates;
}

}  // namespace livegs
