#include "window/keys.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace fumarole::window {

const std::vector<KeyBinding>& key_table()
{
    static const std::vector<KeyBinding> table{
        {Action::raymarch, GLFW_KEY_1, false, "1", "ray march"},
        {Action::froxel, GLFW_KEY_2, false, "2", "froxels"},
        {Action::reference, GLFW_KEY_3, false, "3", "the reference, tile by tile"},
        {Action::split, GLFW_KEY_S, false, "S", "split screen: drag the line"},
        {Action::difference, GLFW_KEY_D, false, "D", "difference of the two in false colour"},
        {Action::see_inside, GLFW_KEY_V, false, "V",
         "see inside: the next of transmittance, steps, bricks, ..."},
        {Action::fit, GLFW_KEY_F, false, "F", "fit the media in the picture"},
        {Action::first_camera, GLFW_KEY_R, false, "R", "the scene's own camera again"},
        {Action::lights, GLFW_KEY_L, false, "L",
         "handles to drag lights, probes and transparents by, on or off"},
        {Action::play, GLFW_KEY_SPACE, false, "Space", "play or pause"},
        {Action::frame_back, GLFW_KEY_LEFT, false, "Left", "a frame back"},
        {Action::frame_on, GLFW_KEY_RIGHT, false, "Right", "a frame on"},
        {Action::first_frame, GLFW_KEY_HOME, false, "Home", "the first frame"},
        {Action::panel, GLFW_KEY_TAB, false, "Tab", "the panel, on or off"},
        {Action::copy_command, GLFW_KEY_C, true, "Ctrl+C",
         "copy the command line that makes this picture"},
        {Action::save_png, GLFW_KEY_P, true, "Ctrl+P", "save the picture as PNG"},
        {Action::save_exr, GLFW_KEY_E, true, "Ctrl+E", "save it as EXR, all targets"},
        {Action::save_scene, GLFW_KEY_S, true, "Ctrl+S", "save the scene"},
        {Action::browse, GLFW_KEY_O, true, "Ctrl+O", "look for a file to open, by pictures"},
        {Action::help, GLFW_KEY_SLASH, false, "?", "these keys, on or off"},
        {Action::close, GLFW_KEY_ESCAPE, false, "Esc", "close a message, these keys or the files"},
    };
    return table;
}

const std::vector<std::pair<std::string_view, std::string_view>>& pointer_table()
{
    static const std::vector<std::pair<std::string_view, std::string_view>> table{
        {"drag", "orbit"},
        {"middle drag, Shift+drag", "pan"},
        {"wheel", "dolly"},
        {"right drag", "look around; with W A S D Q E held: fly"},
        {"drag a light", "move it, or turn the sun"},
        {"drop a file", "open it"},
    };
    return table;
}

std::string key_help()
{
    std::string text = "Keys:\n";
    for (const KeyBinding& binding : key_table())
        text += fmt::format("  {:<26}{}\n", binding.name, binding.help);
    text += "Pointer:\n";
    for (const auto& [gesture, meaning] : pointer_table())
        text += fmt::format("  {:<26}{}\n", gesture, meaning);
    return text;
}

int key_called(std::string_view name)
{
    std::string upper(name);
    std::transform(upper.begin(), upper.end(), upper.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    for (const KeyBinding& binding : key_table()) {
        std::string known(binding.name);
        std::transform(known.begin(), known.end(), known.begin(),
                       [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
        if (!binding.control && known == upper)
            return binding.key;
    }
    if (upper.size() == 1 && (std::isalnum(static_cast<unsigned char>(upper[0])) != 0))
        return upper[0];  // GLFW's codes of letters and digits are their characters
    if (upper == "ENTER")
        return GLFW_KEY_ENTER;
    if (upper == "UP")
        return GLFW_KEY_UP;
    if (upper == "DOWN")
        return GLFW_KEY_DOWN;
    if (upper == "END")
        return GLFW_KEY_END;
    if (upper == "BACKSPACE")
        return GLFW_KEY_BACKSPACE;
    return -1;
}

}  // namespace fumarole::window
