#include "study/flag_names.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fumarole/settings.h>

namespace fumarole::study {

namespace {

bool in_name(char c)
{
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == ':';
}

/// The flag of a member, or its own name if it has none.
std::string flag_of(std::string_view member)
{
    for (const SettingInfo& info : setting_table())
        if (info.member == member)
            return "--" + std::string(info.name);
    if (member == "FrameSettings::mode")
        return "--mode";
    if (member == "Scene::resolution")
        return "--size";
    return std::string(member);
}

}  // namespace

std::string with_flags(std::string_view message)
{
    std::string text;
    while (!message.empty()) {
        const auto begin = std::find_if(message.begin(), message.end(), in_name);
        auto end = std::find_if_not(begin, message.end(), in_name);
        while (end != begin && end[-1] == ':')  // of the sentence
            --end;
        if (end == begin && begin != message.end())
            ++end;
        text.append(message.begin(), begin);
        text += flag_of({begin, end});
        message.remove_prefix(static_cast<std::size_t>(end - message.begin()));
    }
    return text;
}

}  // namespace fumarole::study
