// Rules for the scripts of the studio and of the page; names and types are TypeScript's to check.
import { createRequire } from "node:module";

const js = createRequire(`${process.env.LIPSYNC_LANG_NODE_MODULES}/`)("@eslint/js");

export default [
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2024, sourceType: "module" },
    rules: {
      "eqeqeq": "error",
      "no-eval": "error",
      "no-implied-eval": "error",
      "no-restricted-properties": ["error", { property: "innerHTML" }, { property: "outerHTML" }, { property: "insertAdjacentHTML" }],
      "no-undef": "off",
      "no-unused-vars": ["error", { argsIgnorePattern: "^_", destructuredArrayIgnorePattern: "^_", ignoreRestSiblings: true }],
      "no-var": "error",
      "prefer-const": "error",
    },
  },
  { files: ["**/studio/static/**"], rules: { "max-len": ["error", { code: 120 }] } },
];
