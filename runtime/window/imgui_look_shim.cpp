/* Sets Dear ImGui's font and colours. */
#include "runtime/window/imgui_look_shim.h"

#include <imgui.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace
{

constexpr float TEXT_PX = 15.0f;
constexpr long FONT_BYTES_LIMIT = 1 << 26;

/* Reads a whole file into ImGui's memory; NULL if it cannot be read. */
void *read_file(const char *path, int *bytes)
{
    void *data = nullptr;
    std::FILE *file = std::fopen(path, "rb");
    if (file == nullptr)
        return nullptr;
    long size = std::fseek(file, 0, SEEK_END) == 0 ? std::ftell(file) : -1;
    if (size > 0 && size <= FONT_BYTES_LIMIT && std::fseek(file, 0, SEEK_SET) == 0)
        data = std::malloc(static_cast<size_t>(size));
    if (data != nullptr && std::fread(data, static_cast<size_t>(size), 1, file) != 1) {
        std::free(data);
        data = nullptr;
    }
    std::fclose(file);
    *bytes = static_cast<int>(size);
    return data;
}

/* Loads a font with accents if the system has one. Otherwise ImGui's own ASCII font, in whole
 * multiples of its pixels, so that it stays sharp. */
void load_font(double scale)
{
    static const char *const paths[] = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/TTF/DejaVuSans.ttf",
        "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/freefont/FreeSans.ttf",
    };
    static const ImWchar ranges[] = {0x20,   0x24f,  0x370,  0x52f,  0x2010, 0x2044,
                                     0x2190, 0x2193, 0x2200, 0x2265, 0};
    ImFontAtlas *fonts = ImGui::GetIO().Fonts;
    fonts->Clear();
    ImFontConfig config;
    config.OversampleH = 2;
    config.PixelSnapH = true;
    float size = std::floor(TEXT_PX * static_cast<float>(scale) + 0.5f);
    for (const char *path : paths) {
        int bytes = 0;
        void *data = read_file(path, &bytes); /* the atlas owns it from here on */
        if (data != nullptr &&
            fonts->AddFontFromMemoryTTF(data, bytes, size, &config, ranges) != nullptr)
            return;
    }
    ImFontConfig plain;
    plain.SizePixels = 13.0f * std::fmax(1.0f, std::floor(static_cast<float>(scale) + 0.5f));
    fonts->AddFontDefault(&plain);
}

void set_style(double scale)
{
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 0.0f;
    style.FrameRounding = 3.0f;
    style.GrabRounding = 3.0f;
    style.PopupRounding = 3.0f;
    style.WindowBorderSize = 0.0f;
    style.WindowPadding = ImVec2(10.0f, 8.0f);
    style.FramePadding = ImVec2(6.0f, 3.0f);
    style.ItemSpacing = ImVec2(8.0f, 5.0f);
    style.ScrollbarSize = 11.0f;
    ImVec4 *c = style.Colors;
    c[ImGuiCol_WindowBg] = ImVec4(0.105f, 0.112f, 0.125f, 1.0f);
    c[ImGuiCol_PopupBg] = ImVec4(0.13f, 0.14f, 0.155f, 0.98f);
    c[ImGuiCol_FrameBg] = ImVec4(0.19f, 0.205f, 0.23f, 1.0f);
    c[ImGuiCol_FrameBgHovered] = ImVec4(0.25f, 0.27f, 0.30f, 1.0f);
    c[ImGuiCol_FrameBgActive] = ImVec4(0.28f, 0.30f, 0.34f, 1.0f);
    c[ImGuiCol_Header] = ImVec4(0.165f, 0.18f, 0.205f, 1.0f);
    c[ImGuiCol_HeaderHovered] = ImVec4(0.22f, 0.245f, 0.28f, 1.0f);
    c[ImGuiCol_HeaderActive] = ImVec4(0.25f, 0.28f, 0.32f, 1.0f);
    c[ImGuiCol_Button] = ImVec4(0.21f, 0.235f, 0.27f, 1.0f);
    c[ImGuiCol_ButtonHovered] = ImVec4(0.28f, 0.33f, 0.39f, 1.0f);
    c[ImGuiCol_ButtonActive] = ImVec4(0.20f, 0.42f, 0.55f, 1.0f);
    c[ImGuiCol_CheckMark] = ImVec4(0.38f, 0.74f, 0.92f, 1.0f);
    c[ImGuiCol_SliderGrab] = ImVec4(0.30f, 0.60f, 0.78f, 1.0f);
    c[ImGuiCol_SliderGrabActive] = ImVec4(0.38f, 0.74f, 0.92f, 1.0f);
    c[ImGuiCol_PlotLines] = ImVec4(0.38f, 0.74f, 0.92f, 1.0f);
    c[ImGuiCol_PlotHistogram] = ImVec4(0.30f, 0.60f, 0.78f, 1.0f);
    c[ImGuiCol_TextDisabled] = ImVec4(0.60f, 0.63f, 0.68f, 1.0f);
    c[ImGuiCol_TitleBgActive] = c[ImGuiCol_Header];
    style.ScaleAllSizes(static_cast<float>(scale));
    ImGui::GetStyle() = style;
}

} // namespace

bool stp_ui_look_set(double scale)
{
    try {
        set_style(scale);
        load_font(scale);
        return true;
    } catch (...) {
        return false;
    }
}
