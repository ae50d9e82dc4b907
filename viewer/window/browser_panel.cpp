#include "window/browser_panel.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>
#include <optional>

namespace fumarole::window {

namespace {

// In ems, the height of a letter.
constexpr float kCellWidth = 11;
constexpr float kPictureHeight = kCellWidth * 3 / 4;  // as `fumarole thumbnail` makes them
constexpr float kCellHeight = kPictureHeight + 2.6f;
constexpr float kMostWidth = 62, kMostHeight = 42;
constexpr int kUploads = 4;  // textures a frame

const ImU32 kInk = IM_COL32(225, 225, 225, 255), kFaint = IM_COL32(150, 150, 155, 255),
            kPaper = IM_COL32(38, 38, 42, 255), kWrong = IM_COL32(235, 130, 110, 255);

/// As much of a text as has room, with dots in its middle: the ends of names tell most.
std::string shortened(const std::string& text, float width)
{
    const auto fits = [&](const std::string& part) {
        return ImGui::CalcTextSize(part.c_str()).x <= width;
    };
    if (fits(text))
        return text;
    std::size_t kept = text.size();
    std::string part;
    const auto inside = [&](std::size_t at) {  // of a character of UTF-8
        return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0U) == 0x80U;
    };
    do {
        --kept;
        std::size_t head = kept / 2, tail = text.size() - (kept - kept / 2);
        while (head > 0 && inside(head))
            --head;
        while (inside(tail))
            ++tail;
        part = text.substr(0, head) + "..." + text.substr(tail);
    } while (kept > 2 && !fits(part));
    return part;
}

ImVec2 im(glm::vec2 v)
{
    return {v.x, v.y};
}

void draw_folder(ImDrawList& draw, glm::vec2 at, glm::vec2 size)
{
    const glm::vec2 body = size * glm::vec2(0.46f, 0.5f), corner = at + 0.5f * (size - body);
    const ImU32 color = IM_COL32(120, 125, 140, 255);
    draw.AddRectFilled(im(corner - glm::vec2(0, 0.16f * body.y)),
                       im(corner + glm::vec2(0.4f, 0.2f) * body), color, 0.06f * body.x);
    draw.AddRectFilled(im(corner), im(corner + body), color, 0.06f * body.x);
}

/// A text within a box, in as many lines as that has.
void draw_wrapped(ImDrawList& draw, const std::string& text, ImU32 color, glm::vec2 at,
                  glm::vec2 size)
{
    draw.PushClipRect(im(at), im(at + size), true);
    draw.AddText(nullptr, 0, im(at), color, text.c_str(), nullptr, size.x);
    draw.PopClipRect();
}

}  // namespace

unsigned BrowserPanel::texture_of(const FileEntry& entry, const Thumbnail& thumbnail)
{
    const ThumbnailPicture& picture = thumbnail.picture;
    if (picture.width == 0)
        return 0;
    gl::Texture& texture = textures_[entry.pictured];
    if (!texture && uploads_left_ > 0) {
        --uploads_left_;
        texture =
            gl::Texture::make_2d(device_, "thumbnail", glm::ivec2(picture.width, picture.height),
                                 GL_RGBA8, gl::Filter::linear);
        texture.upload(GL_RGBA, GL_UNSIGNED_BYTE, picture.rgba.data());
    }
    return texture.id();
}

void BrowserPanel::draw_cell(const FileEntry& entry, const Thumbnail& thumbnail, const Cell& cell)
{
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float em = ImGui::GetFontSize(), line = ImGui::GetTextLineHeight();
    const glm::vec2 inset(0.4f * em), at = cell.at + inset;
    const glm::vec2 picture(cell.size.x - 2 * inset.x, kPictureHeight * em - 2 * inset.y);
    if (cell.chosen || cell.hovered)
        draw.AddRectFilled(im(cell.at), im(cell.at + cell.size),
                           ImGui::GetColorU32(cell.chosen ? ImGuiCol_Header : ImGuiCol_FrameBg), 3);
    if (entry.kind == FileEntry::Kind::folder) {
        draw_folder(draw, at, picture);
    } else {
        if (entry.kind == FileEntry::Kind::sequence)  // a pile of them
            for (const float behind : {0.36f, 0.18f})
                draw.AddRectFilled(im(at + glm::vec2(behind * em, -behind * em)),
                                   im(at + picture + glm::vec2(behind * em, -behind * em)),
                                   IM_COL32(70, 70, 76, 255), 2);
        draw.AddRectFilled(im(at), im(at + picture), kPaper, 2);
        if (const unsigned texture = texture_of(entry, thumbnail); texture != 0) {
            const glm::vec2 size(thumbnail.picture.width, thumbnail.picture.height);
            const glm::vec2 drawn = size * std::min(picture.x / size.x, picture.y / size.y);
            const glm::vec2 corner = at + 0.5f * (picture - drawn);
            // NOLINTNEXTLINE(performance-no-int-to-ptr): that is how Dear ImGui takes a texture.
            draw.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture)),
                          im(corner), im(corner + drawn));
        } else if (!thumbnail.error.empty()) {
            draw_wrapped(draw, thumbnail.error, kWrong, at + 0.5f * inset, picture - inset);
        } else {
            draw.AddText(im(at + 0.5f * picture - glm::vec2(0.8f * em, 0.5f * em)), kFaint, "...");
        }
    }
    const float left = cell.at.x + inset.x;
    float top = cell.at.y + kPictureHeight * em;
    draw.AddText({left, top}, kInk, shortened(entry.name, picture.x).c_str());
    top += line;
    draw.AddText({left, top}, kFaint, shortened(describe(entry), picture.x).c_str());
}

void BrowserPanel::draw_path(FileBrowser& browser)
{
    if (ImGui::Button("up"))
        browser.go_up();
    ImGui::SameLine();
    if (folder_ != browser.folder()) {
        folder_ = path_ = browser.folder();
        textures_.clear();
    }
    ImGui::SetNextItemWidth(-1);
    if (ImGui::InputText("##folder", &path_, ImGuiInputTextFlags_EnterReturnsTrue))
        browser.take_path(path_);
}

void BrowserPanel::draw_entries(FileBrowser& browser, float height)
{
    const float em = ImGui::GetFontSize();
    ImGui::BeginChild("entries", {0, height});
    const std::vector<FileEntry>& entries = browser.entries();
    std::optional<std::size_t> taken;
    if (!browser.error().empty())
        ImGui::TextWrapped("%s", browser.error().c_str());
    else if (entries.empty())
        ImGui::TextDisabled("%s", browser.listing() ? "reading ..."
                                                    : "no folder, .vdb, .nvdb or scene is here");
    const float width = ImGui::GetContentRegionAvail().x;
    const auto columns =
        static_cast<std::size_t>(std::max(1.0f, std::floor(width / (kCellWidth * em))));
    const glm::vec2 size(width / static_cast<float>(columns), kCellHeight * em);
    const std::size_t rows = (entries.size() + columns - 1) / columns;
    browser.set_layout(columns, static_cast<std::size_t>(std::max(1.0f, height / size.y)));
    const bool moved = browser.take_moved();
    const ImVec2 begin = ImGui::GetCursorPos(), origin = ImGui::GetCursorScreenPos();
    const float scroll = ImGui::GetScrollY();
    const auto first_row = static_cast<std::size_t>(std::max(0.0f, scroll / size.y));
    const std::size_t end_row =
        std::min(rows, first_row + static_cast<std::size_t>(height / size.y) + 2);
    for (std::size_t i = first_row * columns; i < std::min(end_row * columns, entries.size());
         ++i) {
        const glm::vec2 offset = size * glm::vec2(i % columns, i / columns);
        ImGui::SetCursorPos({begin.x + offset.x, begin.y + offset.y});
        ImGui::PushID(static_cast<int>(i));
        const bool clicked = ImGui::InvisibleButton("entry", im(size));
        const Thumbnail& thumbnail = browser.thumbnail(entries[i]);
        draw_cell(entries[i], thumbnail,
                  {glm::vec2(origin.x, origin.y) + offset, size - glm::vec2(2),
                   i == browser.chosen(), ImGui::IsItemHovered()});
        const bool twice =
            ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("%s%s%s", entries[i].name.c_str(),
                              thumbnail.error.empty() ? "" : "\n", thumbnail.error.c_str());
        ImGui::PopID();
        if (clicked || twice)
            browser.choose(i);
        if (twice)
            taken = i;
    }
    ImGui::SetCursorPos({begin.x, begin.y + size.y * static_cast<float>(rows)});
    ImGui::Dummy({1, 1});
    if (moved) {
        const float top = size.y * static_cast<float>(browser.chosen() / columns);
        if (top < scroll)
            ImGui::SetScrollY(top);
        else if (top + size.y > scroll + height)
            ImGui::SetScrollY(top + size.y - height + 0.5f * em);
    }
    ImGui::EndChild();
    browser.show(first_row * columns, end_row * columns);
    if (textures_.size() > FileBrowser::kMostPictures)
        std::erase_if(textures_, [&](const auto& texture) { return !browser.has(texture.first); });
    if (taken)
        browser.take(*taken);
}

void BrowserPanel::draw_chosen(FileBrowser& browser)
{
    const std::size_t chosen = browser.chosen();
    const bool any = chosen < browser.entries().size();
    if (any) {
        const FileEntry& entry = browser.entries()[chosen];
        const std::string& error = browser.thumbnail(entry).error;
        const float width = ImGui::GetContentRegionAvail().x;
        ImGui::TextUnformatted(
            shortened(fmt::format("{}   {}", entry.name, describe(entry)), width).c_str());
        if (!error.empty()) {
            ImGui::PushStyleColor(ImGuiCol_Text, kWrong);
            ImGui::TextUnformatted(shortened(error, width).c_str());
            ImGui::PopStyleColor();
        } else {
            ImGui::TextDisabled("arrows and letters choose, Enter opens, Backspace goes up");
        }
    } else {
        ImGui::TextUnformatted("");
        ImGui::TextDisabled("Backspace goes up");
    }
    if (ImGui::Button("open") && any)
        browser.take(chosen);
    ImGui::SameLine();
    if (ImGui::Button("cancel"))
        browser.close();
}

void BrowserPanel::draw(FileBrowser& browser, glm::vec2 size)
{
    uploads_left_ = kUploads;
    const float em = ImGui::GetFontSize();
    const glm::vec2 extent = glm::min(0.94f * size, em * glm::vec2(kMostWidth, kMostHeight));
    ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize(im(extent));
    bool open = true;
    ImGui::Begin("open a file", &open,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoSavedSettings);
    draw_path(browser);
    const float below = 2 * ImGui::GetTextLineHeightWithSpacing() +
                        ImGui::GetFrameHeightWithSpacing() + ImGui::GetStyle().ItemSpacing.y;
    draw_entries(browser, std::max(4 * em, ImGui::GetContentRegionAvail().y - below));
    draw_chosen(browser);
    ImGui::End();
    if (!open)
        browser.close();
}

}  // namespace fumarole::window
