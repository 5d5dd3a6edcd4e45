/* Wraps Dear ImGui's draw list behind all panels in C functions. */
#include "runtime/window/imgui_marks_shim.h"

#include <imgui.h>

#include <cmath>

namespace
{

template <typename Body> void guard(Body body) noexcept
{
    try {
        if (!stp_ui_is_exhausted())
            body();
    } catch (...) { /* ImGui's memory ran out; its allocator has recorded that */
    }
}

ImU32 colour_of(uint32_t rgba)
{
    return IM_COL32(rgba >> 24, rgba >> 16 & 255u, rgba >> 8 & 255u, rgba & 255u);
}

ImVec2 at(double x, double y)
{
    return ImVec2(static_cast<float>(x), static_cast<float>(y));
}

} // namespace

void stp_ui_draw_line(double x0, double y0, double x1, double y1, uint32_t colour, double width)
{
    guard([&] {
        ImGui::GetBackgroundDrawList()->AddLine(at(x0, y0), at(x1, y1), colour_of(colour),
                                                static_cast<float>(width));
    });
}

void stp_ui_draw_circle(double x, double y, double radius, uint32_t colour, double width)
{
    guard([&] {
        ImGui::GetBackgroundDrawList()->AddCircle(at(x, y), static_cast<float>(radius),
                                                  colour_of(colour), 0, static_cast<float>(width));
    });
}

void stp_ui_draw_disc(double x, double y, double radius, uint32_t colour)
{
    guard([&] {
        ImGui::GetBackgroundDrawList()->AddCircleFilled(at(x, y), static_cast<float>(radius),
                                                        colour_of(colour));
    });
}

void stp_ui_draw_label(double x, double y, const char *text, uint32_t colour, bool centred)
{
    guard([&] {
        ImDrawList *list = ImGui::GetBackgroundDrawList();
        ImVec2 size = ImGui::CalcTextSize(text), p = at(x, y);
        float pad = 0.3f * ImGui::GetFontSize();
        if (centred)
            p = ImVec2(std::floor(p.x - 0.5f * size.x), std::floor(p.y - 0.5f * size.y));
        else
            p = ImVec2(std::floor(p.x + pad), std::floor(p.y + 0.5f * pad));
        list->AddRectFilled(ImVec2(p.x - pad, p.y - 0.5f * pad),
                            ImVec2(p.x + size.x + pad, p.y + size.y + 0.5f * pad),
                            IM_COL32(16, 18, 22, 190), 3.0f);
        list->AddText(p, colour_of(colour), text);
    });
}

double stp_ui_draw_bar(const stp_ui_rect *rect, const char *text)
{
    double height = 0.0;
    guard([&] {
        ImDrawList *list = ImGui::GetBackgroundDrawList();
        float pad = 0.5f * ImGui::GetFontSize();
        float wrap = static_cast<float>(rect->width) - 2.0f * pad;
        ImVec2 size = ImGui::CalcTextSize(text, nullptr, false, wrap), p = at(rect->x, rect->y);
        height = static_cast<double>(size.y + pad);
        list->AddRectFilled(p, at(rect->x + rect->width, rect->y + height),
                            IM_COL32(160, 32, 24, 235));
        list->AddText(nullptr, 0.0f, ImVec2(p.x + pad, p.y + 0.5f * pad), IM_COL32_WHITE, text,
                      nullptr, wrap);
    });
    return height;
}

void stp_ui_clip_push(const stp_ui_rect *rect)
{
    guard([&] {
        ImGui::GetBackgroundDrawList()->PushClipRect(
            at(rect->x, rect->y), at(rect->x + rect->width, rect->y + rect->height), true);
    });
}

void stp_ui_clip_pop(void)
{
    guard([] { ImGui::GetBackgroundDrawList()->PopClipRect(); });
}

double stp_ui_text_height(void)
{
    return ImGui::GetCurrentContext() != nullptr ? static_cast<double>(ImGui::GetFontSize()) : 0.0;
}
