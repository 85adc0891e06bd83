// Order of the search results: pages whose title has the words asked for, as whole words, come first.
var asked = (new URLSearchParams(location.search).get("q") || "").trim();
var letters = asked.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
var inTitle = new RegExp(`(^|[^\\p{L}\\p{N}_])${letters}($|[^\\p{L}\\p{N}_])`, "iu");
var Scorer = {
  score: ([page, title, , , score, , kind]) => {
    const whole = asked && !page.startsWith("reference/") && inTitle.test(title);
    return score + (whole && kind !== "object" ? 100 : 0);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
