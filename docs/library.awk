# The reference of the library as a page, from linkwright.h:  awk -f docs/library.awk linkwright.h linkwright.h
# First pass: the functions of each section for the list at the top.  Second pass: each comment as text, what it stands above as code.
FNR == 1        { pass++; intro = pass == 2; if (intro) print "# Library reference\n" }
/^\/\* ---- /   { name = $0; gsub(/^\/\* -+ | -+ \*\/$/, "", name) }
pass == 1       {
    if (/^\/\* ---- /) section[++n] = name
    if (/^LW_API/ && match($0, /lw_[a-z0-9_]+\(/)) names[n] = names[n] (names[n] ? ", " : "") "`" substr($0, RSTART, RLENGTH - 1) "`"
    next
}
intro           {
    sub(/^\/\* linkwright\.h - /, "`linkwright.h` is "); sub(/^ \*\/?( |$)/, ""); last = sub(/ \*\/$/, "")
    print
    if (last) { print "\n| section | functions |\n|---|---|"; for (i = 1; i <= n; i++) print "| " section[i] " | " names[i] " |"; intro = 0 }
    next
}
/^\/\* ---- /   { code(0); print "\n## " name; next }
/^#(ifndef|define|endif|include|ifdef) *(LINKWRIGHT_H|__cplusplus|<|LW_API|$)|^extern "C"|^}$/ { next }
/^$/            { code(0); next }
!open && /^\/\*/ || comment {
    comment = !/\*\/$/
    sub(/^\/\* /, ""); sub(/^ \* ?/, ""); sub(/ ?\*\/$/, "")
    if (!said) { print ""; said = 1 }
    print
    next
}
                { code(1); print }
END             { code(0) }
function code(on)
{
    if (on != open) print on ? "\n```c" : "```"
    open = on; said = 0
}
